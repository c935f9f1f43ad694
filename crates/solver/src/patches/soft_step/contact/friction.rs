//! Friction and twist of a patch in a visit.

use super::block::Block;
use super::kinds::Kinds;
use super::visit::{Carried, Visit};
use crate::lanes::{F32xN, Kernel, SpatialVec, square_length, squared};

/// Slip beyond the reach of its spring at which a patch takes its anchor along, m. Impulses that have not converged yet let resting bodies
/// slip by less; without this margin, walls that settle drift half as far again.
const ANCHOR_PLAY: f32 = 1e-3;

/// Factor by which friction may exceed the cone of normals that were relaxed after it. At 1.05, bodies that slide and tremble lose some of
/// their friction in every visit, and boxes that bounce begin to turn.
const CONE_SLACK: f32 = 2.0;

/// Coefficients of friction rows: a spring about the anchor, if friction is anchored.
pub struct Hold<L> {
    pub mass_scale: L,
    pub impulse_scale: L,
    /// Velocities that correct the slip, along the tangents and about the normal.
    pub back: [L; 2],
    pub back_twist: L,
}

impl<L: F32xN> Block<L> {
    /// Coefficients of friction: anchored friction is a spring about its anchor, other friction is rigid.
    #[inline(always)]
    pub fn hold<K: Kinds<L>>(&self, kinds: K, moved: &SpatialVec<L>) -> Hold<L> {
        let soft = &self.softness;
        let rate = self.anchored * soft.bias_rate;
        let (speed, slowest) = (self.max_speed, -self.max_speed);
        let back = [
            rate * (self.slip[0] + moved.linear.y),
            rate * (self.slip[1] + moved.linear.z),
        ];
        Hold {
            mass_scale: self.anchored.mul_add(soft.mass_scale - L::ONE, L::ONE),
            impulse_scale: self.anchored * kinds.given_back(soft.impulse_scale),
            back: [
                back[0].min(speed).max(slowest),
                back[1].min(speed).max(slowest),
            ],
            back_twist: rate * (self.slip_twist + moved.angular.x),
        }
    }

    /// The largest moment about the normal that friction can give, N·m·s.
    #[inline(always)]
    pub fn most_twist(&self, carried: &Carried<L>) -> L {
        self.friction
            .mul_add(carried.lever, self.rolling_lever * carried.all)
    }

    /// Moves the anchor of a sliding patch along. The springs of friction (or their anchor position where none is set yet) stretch no
    /// farther than the friction of the carried load can hold. Otherwise a body that slides and stops within one step, and so counts as
    /// sticking, would be drawn back by the whole slide.
    #[inline(always)]
    pub fn drag<K: Kinds<L>>(&mut self, kinds: K, carried: &Carried<L>, moved: &SpatialVec<L>) {
        let pull = [
            self.compliance.mul_sub(self.held[0], self.slip[0]) - moved.linear.y,
            self.compliance.mul_sub(self.held[1], self.slip[1]) - moved.linear.z,
        ];
        let pull_twist = self
            .compliance_twist
            .mul_sub(self.held_twist, self.slip_twist)
            - moved.angular.x;
        let turned = pull_twist.max(-pull_twist) * self.radius;
        let play = L::splat(ANCHOR_PLAY);
        if square_length(pull).any_above(squared(play)) || turned.any_above(play) {
            L::run_rarely(Drag {
                block: self,
                kinds,
                carried: *carried,
                pull,
                pull_twist,
            });
        }
    }

    /// Relaxes twist, then both tangents, within the friction of the current normal impulses, in lanes that are soft (`SOFT`) or in those
    /// that are rigid.
    #[inline(always)]
    pub fn relax_friction<K: Kinds<L>, const SOFT: bool>(
        &mut self,
        kinds: K,
        carried: &Carried<L>,
        visit: &mut Visit<L>,
        hold: &Hold<L>,
    ) {
        let (mut mass, mut start) = (self.twist_mass, L::ZERO);
        if SOFT {
            mass = mass * hold.mass_scale;
            let given_back = hold.impulse_scale * (self.held_twist - self.twist);
            start = mass.neg_mul_add(hold.back_twist, given_back);
        }
        let limit = self.most_twist(carried);
        let twist = mass.neg_mul_add(visit.velocity.angular.x, start);
        let twist = twist.min(limit - self.twist).max(-limit - self.twist);
        let found = of::<_, _, SOFT>(kinds, self.twist + twist, self.twist);
        let twist = found - self.twist;
        self.twist = found;

        let mut excess = [visit.velocity.linear.y, visit.velocity.linear.z];
        let mut start = self.tangential;
        if SOFT {
            excess = [excess[0] + hold.back[0], excess[1] + hold.back[1]];
            let [x, y] = self.held;
            start = [
                hold.impulse_scale.mul_add(x - start[0], start[0]),
                hold.impulse_scale.mul_add(y - start[1], start[1]),
            ];
        }
        let excess = [
            self.twist_to_tangents[0].mul_add(twist, excess[0]),
            self.twist_to_tangents[1].mul_add(twist, excess[1]),
        ];
        let excess = match SOFT {
            true => [hold.mass_scale * excess[0], hold.mass_scale * excess[1]],
            false => excess,
        };
        // The exact step if it stays inside the cone, else an isotropic one, projected (see `points/constraint.rs`).
        let [xx, yy, xy] = self.tangent_mass;
        let mut found = [
            xy.neg_mul_add(excess[1], xx.neg_mul_add(excess[0], start[0])),
            yy.neg_mul_add(excess[1], xy.neg_mul_add(excess[0], start[1])),
        ];
        let limit = self.friction * carried.all;
        if square_length(found).any_above(squared(limit)) {
            found = L::run_rarely(Slide {
                found,
                limit,
                start,
                excess,
                isotropic_mass: self.isotropic_mass,
            });
        }
        let [x, y] = self.tangential;
        self.tangential = [
            of::<_, _, SOFT>(kinds, found[0], x),
            of::<_, _, SOFT>(kinds, found[1], y),
        ];
        let change = [self.tangential[0] - x, self.tangential[1] - y];

        visit.wrench.linear.y += change[0];
        visit.wrench.linear.z += change[1];
        visit.wrench.angular.x += twist;
    }

    /// Limits soft friction to the normal impulses after their relaxation. Soft friction was relaxed before them; where they have dropped
    /// since, as after a blow, the friction of the blow would be applied twice.
    #[inline(always)]
    pub fn confine<K: Kinds<L>>(&mut self, kinds: K, carried: L, visit: &mut Visit<L>) {
        let limit = L::splat(CONE_SLACK) * self.friction * carried;
        let [x, y] = self.tangential;
        if square_length([x, y]).any_above(squared(limit)) {
            let found = L::run_rarely(Shorten {
                vector: [x, y],
                limit,
            });
            self.tangential = [kinds.soft(found[0], x), kinds.soft(found[1], y)];
            visit.wrench.linear.y += self.tangential[0] - x;
            visit.wrench.linear.z += self.tangential[1] - y;
        }
    }
}

/// `new` in lanes that are soft (`SOFT`) or in those that are rigid, else `old`.
#[inline(always)]
fn of<L: F32xN, K: Kinds<L>, const SOFT: bool>(kinds: K, new: L, old: L) -> L {
    match SOFT {
        true => kinds.soft(new, old),
        false => kinds.rigid(new, old),
    }
}

/// The rare part of [`Block::drag`].
struct Drag<'a, L: F32xN, K> {
    block: &'a mut Block<L>,
    kinds: K,
    carried: Carried<L>,
    pull: [L; 2],
    pull_twist: L,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Drag<'_, L, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            block,
            kinds,
            carried,
            pull,
            pull_twist,
        } = self;
        let play = L::splat(ANCHOR_PLAY);
        let limit = block.most_twist(&carried);
        let reach = block
            .compliance_twist
            .mul_add(limit, play * block.radius.inverse());
        let angle = pull_twist.max(-pull_twist);
        let cut = (reach * angle.inverse()).min(L::ONE) - L::ONE;
        // Other lanes must get the result that they would get without the sliding one.
        let cut = (angle * block.radius).select_above(play, cut, L::ZERO);
        let cut = kinds.soft(cut, L::ZERO);
        block.slip_twist = cut.neg_mul_add(pull_twist, block.slip_twist);
        block.dragged_twist = cut.mul_add(pull_twist, block.dragged_twist);

        let square = square_length(pull);
        let reach = (block.compliance * block.friction).mul_add(carried.all, play);
        let cut = (reach * square.sqrt().inverse()).min(L::ONE) - L::ONE;
        let cut = kinds.soft(square.select_above(squared(play), cut, L::ZERO), L::ZERO);
        let anchors = block.slip.iter_mut().zip(&mut block.dragged);
        for ((slip, dragged), pull) in anchors.zip(pull) {
            *slip = cut.neg_mul_add(pull, *slip);
            *dragged = cut.mul_add(pull, *dragged);
        }
    }
}

/// Friction that slides in some lane: those lanes take an isotropic step, projected.
struct Slide<L> {
    found: [L; 2],
    limit: L,
    start: [L; 2],
    excess: [L; 2],
    isotropic_mass: L,
}

impl<L: F32xN> Kernel for Slide<L> {
    type Output = [L; 2];

    #[inline(always)]
    fn run(self) -> [L; 2] {
        let slid = [
            self.isotropic_mass
                .neg_mul_add(self.excess[0], self.start[0]),
            self.isotropic_mass
                .neg_mul_add(self.excess[1], self.start[1]),
        ];
        let slid = shorten(slid, self.limit);
        let (square, limit) = (square_length(self.found), squared(self.limit));
        [
            square.select_above(limit, slid[0], self.found[0]),
            square.select_above(limit, slid[1], self.found[1]),
        ]
    }
}

/// [`shorten`] as a kernel.
struct Shorten<L> {
    vector: [L; 2],
    limit: L,
}

impl<L: F32xN> Kernel for Shorten<L> {
    type Output = [L; 2];

    #[inline(always)]
    fn run(self) -> [L; 2] {
        shorten(self.vector, self.limit)
    }
}

/// The vector, shortened to `limit` where it is longer.
#[inline(always)]
pub fn shorten<L: F32xN>(vector: [L; 2], limit: L) -> [L; 2] {
    let length = square_length(vector).sqrt();
    let shorten = length.select_above(limit, limit * length.inverse(), L::ONE);
    [vector[0] * shorten, vector[1] * shorten]
}

impl<L: F32xN> Hold<L> {
    pub const RIGID: Self = Self {
        mass_scale: L::ONE,
        impulse_scale: L::ZERO,
        back: [L::ZERO; 2],
        back_twist: L::ZERO,
    };
}
