//! One visit to a block: relaxes its rows and applies their impulses to the bodies.

use super::block::{Block, Pass, Points, on_normals_local};
use super::kinds::Kinds;
use crate::lanes::{F32xN, Kernel, SpatialVec, State, Vec3xN, square_length, squared};
use std::cell::Cell;

/// Rolling and slipping slower than this (m/s) count as creep.
const CREEP: f32 = 0.1;

/// A patch with a normal velocity above this (m/s) is landing, not resting.
const LANDING: f32 = 0.25;

/// Number of visits to the points of a landing patch.
const LANDING_VISITS: usize = 8;

/// The held load of a point is at most its load at rest times this times the share of its load that the patch still carries. Where a load
/// is removed at once, the slow mean would throw the body that carried it.
const UNLOADED: f32 = 3.0;

/// Slip beyond the reach of its spring at which a patch takes its anchor along, m. Impulses that have not converged yet let resting bodies
/// slip by less; without this margin, walls that settle drift half as far again.
const PLAY: f32 = 1e-3;

/// Factor by which friction may exceed the cone of normals that were relaxed after it. At 1.05, bodies that slide and tremble lose some of
/// their friction in every visit, and boxes that bounce begin to turn.
const STALE: f32 = 2.0;

/// The state of a visit.
struct Visit<L> {
    /// Relative velocity in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    velocity: SpatialVec<L>,
    /// Sum of the wrenches of its rows so far, in the same frame.
    wrench: SpatialVec<L>,
    /// Σ W Δλ² of the normals, J.
    change: L,
}

/// The impulses of a patch's normals.
#[derive(Clone, Copy)]
pub struct Carried<L> {
    /// Σλ_n, N·s.
    pub all: L,
    /// Σλ_n times the distances from the centre, N·m·s.
    lever: L,
}

/// Coefficients of friction rows: a spring about the anchor, if friction is anchored.
struct Hold<L> {
    mass_scale: L,
    impulse_scale: L,
    /// Velocities that correct the slip, along the tangents and about the normal.
    back: [L; 2],
    back_twist: L,
}

/// The springs of a patch's points in one visit.
#[derive(Clone, Copy, Default)]
struct Springs<L> {
    /// Motion of the patch since detection, in the coordinates of normals.
    moved: Vec3xN<L>,
    bias_rate: L,
    /// The fastest correction, as a negative velocity, m/s.
    fastest: L,
    mass_scale: L,
    impulse_scale: L,
    /// The share of its load that the patch still carries, at most 1.
    left: L,
    /// Factors of the load that a point holds, and of the part of its load that it has lost; both include `impulse_scale`.
    held: L,
    preload: L,
    /// Factor from the load of a spring to its reach times its mass, s.
    reach: L,
}

impl<L: F32xN> Block<L> {
    /// One projected Gauss–Seidel visit. In soft lanes, rows are springs and correct errors; friction comes before normals, which matter
    /// more. In rigid lanes, rows only stop the motion; normals come before friction, which therefore ends inside its cone. Returns the
    /// change of the normals, Σ W Δλ², J.
    #[inline(always)]
    pub fn relax<K: Kinds<L>>(
        &mut self,
        kinds: K,
        points: &mut [Points<L>],
        velocities: &[Cell<State>],
        motions: &[Cell<State>],
        pass: &Pass,
    ) -> L {
        let frame = self.frame();
        let a = L::gather(velocities, &self.bodies[0]);
        let b = L::gather(velocities, &self.bodies[1]);
        let mut visit = Visit {
            velocity: self.relative(&frame, a, b),
            wrench: SpatialVec::default(),
            change: L::ZERO,
        };
        self.against_surface(&mut visit.velocity);
        let mut rows = Rows {
            kinds,
            springs: Springs::default(),
            rate: L::splat(pass.rate),
        };
        if K::SOFT {
            self.account(kinds, points);
            let moved_a = L::gather(motions, &self.bodies[0]);
            let moved_b = L::gather(motions, &self.bodies[1]);
            let moved = self.relative(&frame, moved_a, moved_b);
            let carried = Carried::by(points);
            self.drag(kinds, &carried, &moved);
            let hold = self.spring(kinds, &moved);
            self.relax_friction::<_, true>(kinds, &carried, &mut visit, &hold);
            visit.follow_friction(self);
            rows.springs = self.springs(kinds, &carried, &moved, pass);
        }
        if self.rolls && (K::SOFT || K::RUBS) {
            let carried = Carried::by(points);
            visit = L::run_rarely(Roll {
                block: self,
                kinds,
                carried,
                visit,
            });
        }
        kinds.before_normals(self.first, points);
        visit = rows.relax_normals(points, visit);
        kinds.after_normals(self.first, points, &mut visit.wrench);
        if K::SOFT {
            self.confine(kinds, Carried::by(points).all, &mut visit);
        }
        if K::RIGID && K::RUBS {
            visit.follow_normals(self);
            let carried = Carried::by(points);
            self.relax_friction::<_, false>(kinds, &carried, &mut visit, &Hold::RIGID);
        }
        self.push(&frame, visit.wrench, a, b, velocities);
        visit.change
    }

    /// Adds the impulses of the last substep to the sums over the step.
    #[inline(always)]
    pub fn account<K: Kinds<L>>(&mut self, kinds: K, points: &mut [Points<L>]) {
        for (given, now) in self.given.iter_mut().zip(self.tangential) {
            *given = kinds.add_if_again(*given, now);
        }
        for point in points {
            point.given = kinds.add_if_again(point.given, point.impulse);
        }
    }

    /// Coefficients of friction: anchored friction is a spring about its anchor, other friction is rigid.
    #[inline(always)]
    fn spring<K: Kinds<L>>(&self, kinds: K, moved: &SpatialVec<L>) -> Hold<L> {
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
    fn drag<K: Kinds<L>>(&mut self, kinds: K, carried: &Carried<L>, moved: &SpatialVec<L>) {
        let pull = [
            self.compliance.mul_sub(self.held[0], self.slip[0]) - moved.linear.y,
            self.compliance.mul_sub(self.held[1], self.slip[1]) - moved.linear.z,
        ];
        let pull_twist = self
            .compliance_twist
            .mul_sub(self.held_twist, self.slip_twist)
            - moved.angular.x;
        let turned = pull_twist.max(-pull_twist) * self.radius;
        let play = L::splat(PLAY);
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
    fn relax_friction<K: Kinds<L>, const SOFT: bool>(
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
    fn confine<K: Kinds<L>>(&mut self, kinds: K, carried: L, visit: &mut Visit<L>) {
        let limit = L::splat(STALE) * self.friction * carried;
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

    /// The springs of the normals. In rigid lanes they do not yield and hold nothing; in idle lanes they have no effect.
    #[inline(always)]
    fn springs<K: Kinds<L>>(
        &self,
        kinds: K,
        carried: &Carried<L>,
        moved: &SpatialVec<L>,
        pass: &Pass,
    ) -> Springs<L> {
        let soft = &self.softness;
        let impulse_scale = kinds.given_back(soft.impulse_scale);
        let left = carried.all * self.share * self.inverse_load;
        // The largest share of a load that is held.
        let most = (left * L::splat(UNLOADED)).min(L::ONE);
        Springs {
            moved: on_normals_local(moved),
            bias_rate: soft.bias_rate,
            fastest: -self.max_speed,
            mass_scale: kinds.soft(soft.mass_scale, kinds.if_rigid(L::ONE)),
            impulse_scale,
            left: left.min(L::ONE),
            held: impulse_scale * most,
            preload: impulse_scale * L::splat(pass.preload),
            reach: kinds.if_soft(most * self.gives),
        }
    }
}

/// The normal rows of a patch.
#[derive(Clone, Copy)]
struct Rows<L, K> {
    kinds: K,
    /// The springs of soft lanes.
    springs: Springs<L>,
    /// Inverse length of a substep, 1/s.
    rate: L,
}

impl<L: F32xN, K: Kinds<L>> Rows<L, K> {
    /// Returns (mass, constant). A visit takes mass · approach + constant from the point's impulse.
    #[inline(always)]
    fn row(&self, point: &mut Points<L>) -> (L, L) {
        match K::SOFT {
            true => self.spring(point),
            // A rigid row only stops motion, or closes the gap beyond the reach of its spring.
            false => {
                let mass = self.kinds.if_rigid(point.mass);
                (mass, mass * point.gap * self.rate)
            }
        }
    }

    #[inline(always)]
    fn spring(&self, point: &mut Points<L>) -> (L, L) {
        let springs = &self.springs;
        let s = point.separation + point.approach(&springs.moved);
        let s = self.kinds.distance(s, point.gap);
        let lost = point
            .rest_impulse
            .mul_sub(springs.left, point.impulse)
            .max(L::ZERO);
        let soft_mass = springs.mass_scale * point.mass;
        let held = springs
            .held
            .neg_mul_add(point.rest_impulse, springs.impulse_scale * point.impulse);
        let held = springs.preload.mul_add(lost, held);
        let closed = soft_mass.mul_add((springs.bias_rate * s).max(springs.fastest), held);
        // The spring with all of its load rests where the surfaces meet, and reaches as far beyond as that load stretches it.
        let (stretch, reach) = (s * point.mass, springs.reach * point.rest_impulse);
        let gap = stretch.select_above(reach, s, L::ZERO);
        point.gap = self.kinds.visited(gap, point.gap);
        (
            stretch.select_above(reach, point.mass, soft_mass),
            stretch.select_above(reach, stretch * self.rate, closed),
        )
    }

    #[inline(always)]
    fn relax_normals(&self, points: &mut [Points<L>], mut visit: Visit<L>) -> Visit<L> {
        if K::LANDS {
            // Other lanes must get the result that they would get without this one.
            let u = visit.velocity.linear.x;
            let lands = self.kinds.soft(u.max(-u), L::ZERO);
            let landing = L::splat(LANDING);
            if lands.any_above(landing) {
                let lands = lands.select_above(landing, L::ONE, L::ZERO);
                return L::run_rarely(Land {
                    rows: *self,
                    points,
                    visit,
                    lands,
                });
            }
        }
        let mut normals = on_normals_local(&visit.velocity);
        relax_points::<_, _, false>(self, points, &mut normals, &mut visit);
        visit
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

/// Visits the points of a patch one after another, in groups of four. The result for a point does not depend on the number of points in its
/// block.
#[inline(always)]
fn relax_points<L: F32xN, K: Kinds<L>, const ON: bool>(
    rows: &Rows<L, K>,
    mut points: &mut [Points<L>],
    normals: &mut Vec3xN<L>,
    visit: &mut Visit<L>,
) {
    while points.len() > 4 {
        let (some, others) = points.split_at_mut(4);
        relax_n::<_, _, 4, true>(rows, some, normals, visit);
        points = others;
    }
    match points.len() {
        4 => relax_n::<_, _, 4, ON>(rows, points, normals, visit),
        3 => relax_n::<_, _, 3, ON>(rows, points, normals, visit),
        2 => relax_n::<_, _, 2, ON>(rows, points, normals, visit),
        1 => relax_n::<_, _, 1, ON>(rows, points, normals, visit),
        _ => (),
    }
}

/// Visits N points. Each impulse is passed at once to the wanted impulses of the later points: each then waits for three operations of the
/// one before, instead of seven by way of the patch's motion. This pays in a stack, in which no other work fills the wait. The motion
/// itself is updated only if more visits follow (`ON`).
#[inline(always)]
fn relax_n<L: F32xN, K: Kinds<L>, const N: usize, const ON: bool>(
    rows: &Rows<L, K>,
    points: &mut [Points<L>],
    normals: &mut Vec3xN<L>,
    visit: &mut Visit<L>,
) {
    let Ok(points): Result<&mut [Points<L>; N], _> = points.try_into() else {
        unreachable!("so many there are");
    };
    let (mut wanted, mut masses) = ([L::ZERO; N], [L::ZERO; N]);
    let mut approaches = [L::ZERO; N];
    let mut i = 0;
    while i < N {
        let (mass, constant) = rows.row(&mut points[i]);
        approaches[i] = points[i].approach(normals);
        wanted[i] = mass.neg_mul_add(approaches[i], points[i].impulse - constant);
        masses[i] = mass;
        i += 1;
    }
    i = 0;
    while i < N {
        let left = wanted[i].max(L::ZERO);
        let taken = points[i].impulse - left;
        points[i].impulse = left;
        let mut j = i + 1;
        while j < N {
            let seen = points[j].approach(&points[i].effect);
            wanted[j] = (masses[j] * seen).mul_add(taken, wanted[j]);
            approaches[j] = seen.neg_mul_add(taken, approaches[j]);
            j += 1;
        }
        if ON {
            *normals = points[i].effect.scale_neg_add(taken, *normals);
        }
        visit.change = taken.mul_add(approaches[i], visit.change);
        points[i].push(-taken, &mut visit.wrench);
        i += 1;
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
        let play = L::splat(PLAY);
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
fn shorten<L: F32xN>(vector: [L; 2], limit: L) -> [L; 2] {
    let length = square_length(vector).sqrt();
    let shorten = length.select_above(limit, limit * length.inverse(), L::ONE);
    [vector[0] * shorten, vector[1] * shorten]
}

/// Stops creep: relaxes Ω_1 and Ω_2 together, within the limit of the current normal impulses. The limit decreases with speed.
struct Roll<'a, L: F32xN, K> {
    block: &'a mut Block<L>,
    kinds: K,
    carried: Carried<L>,
    visit: Visit<L>,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Roll<'_, L, K> {
    type Output = Visit<L>;

    #[inline(always)]
    fn run(self) -> Visit<L> {
        let Self {
            block,
            kinds,
            carried,
            mut visit,
        } = self;
        let spin = [visit.velocity.angular.y, visit.velocity.angular.z];
        let slip = [visit.velocity.linear.y, visit.velocity.linear.z];
        let rolling = block.rolling_radius * block.rolling_radius;
        let square = rolling.mul_add(square_length(spin), square_length(slip));
        let fast = square.mul_add(L::splat(1.0 / (CREEP * CREEP)), L::ONE);
        let limit = block.rolling_lever * carried.all * (fast * fast).inverse();
        let [xx, yy, xy] = block.rolling_mass;
        let exact = [
            block.rolling[0] - xx.mul_add(spin[0], xy * spin[1]),
            block.rolling[1] - xy.mul_add(spin[0], yy * spin[1]),
        ];
        let found = shorten(exact, limit);
        let [x, y] = block.rolling;
        block.rolling = [
            kinds.soft(found[0], kinds.rigid(found[0], x)),
            kinds.soft(found[1], kinds.rigid(found[1], y)),
        ];
        let change = [block.rolling[0] - x, block.rolling[1] - y];

        visit.wrench.angular.y += change[0];
        visit.wrench.angular.z += change[1];
        let seen = block.normals.apply(Vec3xN {
            x: L::ZERO,
            y: change[0],
            z: change[1],
        });
        visit.velocity.linear.x += seen.x;
        visit.velocity.angular.y += seen.y;
        visit.velocity.angular.z += seen.z;
        visit
    }
}

/// Relaxes a patch that lands on a face, or still has the impulse of landing. The first visited point would turn the body, so all points
/// are stopped together first, and visited more often.
struct Land<'a, L: F32xN, K> {
    rows: Rows<L, K>,
    points: &'a mut [Points<L>],
    visit: Visit<L>,
    /// 1 in landing lanes, else 0.
    lands: L,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Land<'_, L, K> {
    type Output = Visit<L>;

    #[inline(always)]
    fn run(self) -> Visit<L> {
        let Self {
            rows,
            points,
            mut visit,
            lands,
        } = self;
        let mut normals = on_normals_local(&visit.velocity);
        rows.stop_together(points, &mut normals, &mut visit.wrench, lands);
        relax_points::<_, _, true>(&rows, points, &mut normals, &mut visit);
        for _ in 1..LANDING_VISITS {
            let mut most = L::ZERO;
            for point in points.iter_mut() {
                let (mass, constant) = rows.row(point);
                let approach = point.approach(&normals);
                let step = lands * mass.mul_add(approach, constant);
                let taken = point.take(step, &mut normals, &mut visit.wrench);
                visit.change = taken.mul_add(approach, visit.change);
                most = most.max(taken.max(-taken));
            }
            // If the points change nothing now, further visits change nothing either; this is so for a body that has not arrived yet.
            if !most.any_above(L::ZERO) {
                break;
            }
        }
        visit
    }
}

impl<L: F32xN, K: Kinds<L>> Rows<L, K> {
    #[inline(always)]
    fn stop_together(
        &self,
        points: &mut [Points<L>],
        normals: &mut Vec3xN<L>,
        wrench: &mut SpatialVec<L>,
        lands: L,
    ) {
        let before = *normals;
        let mut missing = L::ZERO;
        let (mut force, mut effect) = (Vec3xN::default(), Vec3xN::default());
        for point in points.iter() {
            let (share, lack) = self.lack(point, &before, lands);
            missing = share.mul_add(lack, missing);
            force = point.direction().scale_add(share, force);
            effect = point.effect.scale_add(share, effect);
        }
        let most = missing * force.dot(effect).inverse();
        for point in points.iter_mut() {
            let (share, _) = self.lack(point, &before, lands);
            point.take(-share * most, normals, wrench);
        }
    }

    /// The share of a point in the impulse that stops the patch, in proportion to its missing velocity or its impulse; and that missing
    /// velocity, m/s.
    #[inline(always)]
    fn lack(&self, point: &Points<L>, normals: &Vec3xN<L>, lands: L) -> (L, L) {
        let s = point.separation + point.approach(&self.springs.moved);
        let lack = -s.max(L::ZERO).mul_add(self.rate, point.approach(normals));
        let used = point.mass.select_above(L::ZERO, lands, L::ZERO);
        let share = lack.max(point.impulse).select_above(L::ZERO, used, L::ZERO);
        (share, lack)
    }
}

impl<L: F32xN> Visit<L> {
    /// Adds the response of the tangents to the impulses of the normals.
    #[inline(always)]
    fn follow_normals(&mut self, block: &Block<L>) {
        let given = Vec3xN {
            x: self.wrench.linear.x,
            y: self.wrench.angular.y,
            z: self.wrench.angular.z,
        };
        self.velocity.linear.y += block.tangents_to_normals[0].dot(given);
        self.velocity.linear.z += block.tangents_to_normals[1].dot(given);
        self.velocity.angular.x += block.twist_to_normals.dot(given);
    }

    /// Adds the response of the normals to the impulses of friction.
    #[inline(always)]
    fn follow_friction(&mut self, block: &Block<L>) {
        let before = on_normals_local(&self.velocity);
        let [first, second] = block.tangents_to_normals;
        let after_twist = block
            .twist_to_normals
            .scale_add(self.wrench.angular.x, before);
        let after_two = first.scale_add(self.wrench.linear.y, after_twist);
        let after = second.scale_add(self.wrench.linear.z, after_two);
        self.velocity.linear.x = after.x;
        self.velocity.angular.y = after.y;
        self.velocity.angular.z = after.z;
    }
}

impl<L: F32xN> Points<L> {
    /// Takes from λ_n, which stays ≥ 0, and returns the amount. The amount is the difference of the rounded impulses: differences too small
    /// for λ_n would otherwise act on the bodies alone, and make boxes that bounce straight begin to turn.
    #[inline(always)]
    fn take(&mut self, step: L, normals: &mut Vec3xN<L>, wrench: &mut SpatialVec<L>) -> L {
        let left = (self.impulse - step).max(L::ZERO);
        let taken = self.impulse - left;
        self.impulse = left;
        *normals = self.effect.scale_neg_add(taken, *normals);
        self.push(-taken, wrench);
        taken
    }
}

impl<L: F32xN> Carried<L> {
    #[inline(always)]
    pub fn by(points: &[Points<L>]) -> Self {
        let (mut all, mut lever) = (L::ZERO, L::ZERO);
        for point in points {
            all += point.impulse;
            lever = point.impulse.mul_add(point.radius, lever);
        }
        Self { all, lever }
    }
}

impl<L: F32xN> Hold<L> {
    const RIGID: Self = Self {
        mass_scale: L::ONE,
        impulse_scale: L::ZERO,
        back: [L::ZERO; 2],
        back_twist: L::ZERO,
    };
}
