//! One visit to a block: what its rows find, and what that does to the bodies.

use super::block::{Block, Pass, Points, on_normals_local};
use super::lanes::{F32xN, SpatialVec, State, Vec3xN};

/// What rolls or slips faster than this (m/s) does not creep.
const CREEP: f32 = 0.1;

/// Faster than this (m/s) a patch is landing, not resting.
const LANDING: f32 = 0.25;

/// How often the points of a patch that lands are visited.
const LANDING_VISITS: usize = 8;

/// What a point is held to carry is at most so many times what its patch carries now: where a load is taken away at once, the slow
/// mean would throw what has borne it.
const UNLOADED: f32 = 3.0;

/// How far beyond its spring a patch slips before it takes its anchor along, m. Impulses that have not converged yet let what rests slip by
/// less; without it walls that settle drift half as far again.
const PLAY: f32 = 1e-3;

/// Friction may exceed the cone of normals that were relaxed after it by this factor. Where it may by 1.05 only, what slides and
/// trembles loses some of its friction in every visit, and boxes that bounce begin to turn.
const STALE: f32 = 2.0;

/// A visit on its way.
struct Visit<L> {
    /// Relative velocity in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    velocity: SpatialVec<L>,
    /// What the rows have found so far, in the same frame.
    wrench: SpatialVec<L>,
    /// Σ W Δλ² of the normals, J.
    change: L,
}

/// What the normals of a patch carry.
#[derive(Clone, Copy)]
struct Carried<L> {
    /// Σλ_n, N·s.
    all: L,
    /// The same times the distances from the centre, N·m·s.
    lever: L,
}

/// How friction is held: as a spring about its anchor, or rigidly.
struct Hold<L> {
    mass_scale: L,
    impulse_scale: L,
    /// Velocities that take the slip back, along the tangents and about the normal.
    back: [L; 2],
    back_twist: L,
}

impl<L: F32xN> Block<L> {
    /// One projected Gauss–Seidel visit. With `SOFT` rows are springs and take errors back, friction before normals, which matter
    /// more. Without, they are rigid and only stop the motion, normals before friction, which so ends in its cone. The change
    /// of the normals, Σ W Δλ², J.
    #[inline(always)]
    pub fn relax<const SOFT: bool>(
        &mut self,
        points: &mut [Points<L>],
        velocities: &mut [State],
        motions: &[State],
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
        if SOFT {
            if !pass.first {
                self.account(points);
            }
            let moved_a = L::gather(motions, &self.bodies[0]);
            let moved_b = L::gather(motions, &self.bodies[1]);
            let moved = self.relative(&frame, moved_a, moved_b);
            let carried = Carried::by(points);
            self.drag(&carried, &moved);
            self.relax_friction(&carried, &mut visit, &self.spring(&moved));
            visit.follow_friction(self);
            if self.rolls {
                self.relax_rolling(&carried, &mut visit);
            }
            let moved = on_normals_local(&moved);
            self.relax_normals_softly(points, &carried, &mut visit, &moved, pass);
            self.confine(&Carried::by(points), &mut visit);
        } else {
            if self.rolls {
                self.relax_rolling(&Carried::by(points), &mut visit);
            }
            self.relax_normals_rigidly(points, &mut visit, pass);
            visit.follow_normals(self);
            self.relax_friction(&Carried::by(points), &mut visit, &Hold::RIGID);
        }
        self.push(&frame, visit.wrench, a, b, velocities);
        visit.change
    }

    /// Anchored friction is a spring about where it began to stick; any other is rigid.
    #[inline(always)]
    fn spring(&self, moved: &SpatialVec<L>) -> Hold<L> {
        let soft = &self.softness;
        let rate = self.anchored * soft.bias_rate;
        let speed = self.max_speed;
        let back = [
            rate * (self.slip[0] + moved.linear.y),
            rate * (self.slip[1] + moved.linear.z),
        ];
        Hold {
            mass_scale: self.anchored.mul_add(soft.mass_scale - L::ONE, L::ONE),
            impulse_scale: self.anchored * soft.impulse_scale,
            back: [
                back[0].min(speed).max(-speed),
                back[1].min(speed).max(-speed),
            ],
            back_twist: rate * (self.slip_twist + moved.angular.x),
        }
    }

    /// The most moment about the normal that friction gives, N·m·s.
    #[inline(always)]
    fn most_twist(&self, carried: &Carried<L>) -> L {
        self.friction
            .mul_add(carried.lever, self.rolling_lever * carried.all)
    }

    /// What slides takes its anchor along. The springs of friction, or their place where none is set yet, stretch no farther than the
    /// patch can hold them with what it carries. Else what slides and stops inside one step, and so counts as sticking, would be
    /// drawn back by all that it slid.
    #[inline(always)]
    fn drag(&mut self, carried: &Carried<L>, moved: &SpatialVec<L>) {
        let pull = [
            self.compliance.mul_sub(self.held[0], self.slip[0]) - moved.linear.y,
            self.compliance.mul_sub(self.held[1], self.slip[1]) - moved.linear.z,
        ];
        let pull_twist = self
            .compliance_twist
            .mul_sub(self.held_twist, self.slip_twist)
            - moved.angular.x;
        let square = square_length(pull);
        let angle = pull_twist.max(-pull_twist);
        let play = L::splat(PLAY);
        if !square.any_above(play * play) && !(angle * self.radius).any_above(play) {
            return;
        }
        let length = square.sqrt();
        let limit = self.most_twist(carried);
        let reach = self
            .compliance_twist
            .mul_add(limit, play * self.radius.inverse());
        let cut = (reach * angle.inverse()).min(L::ONE) - L::ONE;
        self.slip_twist = cut.taken_from(pull_twist, self.slip_twist);
        self.dragged_twist = cut.mul_add(pull_twist, self.dragged_twist);

        let reach = (self.compliance * self.friction).mul_add(carried.all, play);
        let cut = (reach * length.inverse()).min(L::ONE) - L::ONE;
        for i in 0..2 {
            self.slip[i] = cut.taken_from(pull[i], self.slip[i]);
            self.dragged[i] = cut.mul_add(pull[i], self.dragged[i]);
        }
    }

    /// Twist, then both tangents, within what the normals carry now.
    #[inline(always)]
    fn relax_friction(&mut self, carried: &Carried<L>, visit: &mut Visit<L>, hold: &Hold<L>) {
        let keep = L::ONE - hold.impulse_scale;

        let limit = self.most_twist(carried);
        let mass = self.twist_mass * hold.mass_scale;
        let start = self
            .twist
            .mul_add(keep, hold.impulse_scale * self.held_twist);
        let start = mass.taken_from(hold.back_twist, start) - self.twist;
        let twist = mass.taken_from(visit.velocity.angular.x, start);
        let twist = twist.min(limit - self.twist).max(-limit - self.twist);
        self.twist += twist;

        let limit = self.friction * carried.all;
        let excess = [
            self.twist_to_tangents[0].mul_add(twist, visit.velocity.linear.y + hold.back[0]),
            self.twist_to_tangents[1].mul_add(twist, visit.velocity.linear.z + hold.back[1]),
        ];
        // The exact step where it stays inside the cone, else an isotropic one, projected (see `rows.rs`).
        let [xx, yy, xy] = self.tangent_mass;
        let start = [
            self.tangential[0].mul_add(keep, hold.impulse_scale * self.held[0]),
            self.tangential[1].mul_add(keep, hold.impulse_scale * self.held[1]),
        ];
        let [xx, yy, xy] = [
            xx * hold.mass_scale,
            yy * hold.mass_scale,
            xy * hold.mass_scale,
        ];
        let mut change = [
            xy.taken_from(
                excess[1],
                xx.taken_from(excess[0], start[0] - self.tangential[0]),
            ),
            yy.taken_from(
                excess[1],
                xy.taken_from(excess[0], start[1] - self.tangential[1]),
            ),
        ];
        let mut found = [
            self.tangential[0] + change[0],
            self.tangential[1] + change[1],
        ];
        let square = square_length(found);
        let limit_square = limit * limit;
        if square.any_above(limit_square) {
            let isotropic = hold.mass_scale * self.isotropic_mass;
            let slid = [
                isotropic.taken_from(excess[0], start[0]),
                isotropic.taken_from(excess[1], start[1]),
            ];
            let length = square_length(slid).sqrt();
            let shorten = length.select_above(limit, limit * length.inverse(), L::ONE);
            found = [
                square.select_above(limit_square, slid[0] * shorten, found[0]),
                square.select_above(limit_square, slid[1] * shorten, found[1]),
            ];
            change = [found[0] - self.tangential[0], found[1] - self.tangential[1]];
        }
        self.tangential = found;

        visit.wrench.linear.y += change[0];
        visit.wrench.linear.z += change[1];
        visit.wrench.angular.x += twist;
    }

    /// Soft friction was found for what normals carried before them. Where they have let go since, as after a blow, friction of the
    /// blow would be given twice.
    #[inline(always)]
    fn confine(&mut self, carried: &Carried<L>, visit: &mut Visit<L>) {
        let limit = L::splat(STALE) * self.friction * carried.all;
        let [x, y] = self.tangential;
        let square = square_length([x, y]);
        if !square.any_above(limit * limit) {
            return;
        }
        let length = square.sqrt();
        let shorten = length.select_above(limit, limit * length.inverse(), L::ONE);
        self.tangential = [x * shorten, y * shorten];
        visit.wrench.linear.y += self.tangential[0] - x;
        visit.wrench.linear.z += self.tangential[1] - y;
    }

    /// What creeps is stopped: Ω_1 and Ω_2 together, within what the normals carry now, and less where it is faster.
    #[inline(always)]
    fn relax_rolling(&mut self, carried: &Carried<L>, visit: &mut Visit<L>) {
        let spin = [visit.velocity.angular.y, visit.velocity.angular.z];
        let slip = [visit.velocity.linear.y, visit.velocity.linear.z];
        let rolling = self.rolling_radius * self.rolling_radius;
        let square = rolling.mul_add(square_length(spin), square_length(slip));
        let fast = square.mul_add(L::splat(1.0 / (CREEP * CREEP)), L::ONE);
        let limit = self.rolling_lever * carried.all * (fast * fast).inverse();
        let [xx, yy, xy] = self.rolling_mass;
        let exact = [
            self.rolling[0] - xx.mul_add(spin[0], xy * spin[1]),
            self.rolling[1] - xy.mul_add(spin[0], yy * spin[1]),
        ];
        let length = square_length(exact).sqrt();
        let shorten = length.select_above(limit, limit * length.inverse(), L::ONE);
        let found = [exact[0] * shorten, exact[1] * shorten];
        let change = [found[0] - self.rolling[0], found[1] - self.rolling[1]];
        self.rolling = found;

        visit.wrench.angular.y += change[0];
        visit.wrench.angular.z += change[1];
        let seen = self.normals.apply(Vec3xN {
            x: L::ZERO,
            y: change[0],
            z: change[1],
        });
        visit.velocity.linear.x += seen.x;
        visit.velocity.angular.y += seen.y;
        visit.velocity.angular.z += seen.z;
    }

    #[inline(always)]
    fn relax_normals_softly(
        &mut self,
        points: &mut [Points<L>],
        carried: &Carried<L>,
        visit: &mut Visit<L>,
        moved: &Vec3xN<L>,
        pass: &Pass,
    ) {
        let soft = &self.softness;
        let mean = carried.all * self.share;
        // The share of its load that the patch still carries, and what of it is held at most.
        let left = mean * self.inverse_load;
        let most = (left * L::splat(UNLOADED)).min(L::ONE);
        let left = left.min(L::ONE);
        let mut normals = on_normals_local(&visit.velocity);
        let (rate, preload) = (L::splat(pass.rate), L::splat(pass.preload));
        // 1 where it lands. The patches beside it must find what they would find alone.
        let landing = L::splat(LANDING);
        let speed = normals.x.max(-normals.x);
        let mut counts = L::ONE;
        let visits = if speed.any_above(landing) {
            let lands = speed.select_above(landing, L::ONE, L::ZERO);
            self.stop_together(points, &lands, &mut normals, &mut visit.wrench, moved, pass);
            LANDING_VISITS
        } else {
            1
        };
        for _ in 0..visits {
            for point in points.iter_mut() {
                let approach = point.approach(&normals);
                let s = point.separation + point.approach(moved);
                point.now = s;
                let push = (-soft.bias_rate * s).min(self.max_speed);
                let load = point.load * most;
                let lost = point.load.mul_sub(left, point.impulse).max(L::ZERO);
                let held = preload.taken_from(lost, load);
                point.reach = load * point.compliance;
                // What there is to give is `constant` − `mass` · approach: all but the last is known before the points
                // that come first.
                let soft_mass = soft.mass_scale * point.mass;
                let closed = soft_mass.mul_sub(push, soft.impulse_scale * (point.impulse - held));
                let constant = s.select_above(point.reach, -s * (point.mass * rate), closed);
                let mass = s.select_above(point.reach, point.mass, soft_mass);
                let change = (counts * mass).taken_from(approach, counts * constant);
                let given = point.give(change, &mut normals, &mut visit.wrench);
                visit.change = given.taken_from(approach, visit.change);
            }
            counts = speed.select_above(landing, L::ONE, L::ZERO);
        }
    }

    /// What lands on a face, or still has the impulse of landing, would be turned by the point that is visited first. So all its
    /// points are stopped together before.
    #[inline(always)]
    fn stop_together(
        &self,
        points: &mut [Points<L>],
        lands: &L,
        normals: &mut Vec3xN<L>,
        wrench: &mut SpatialVec<L>,
        moved: &Vec3xN<L>,
        pass: &Pass,
    ) {
        let mut all = Vec3xN::default();
        let mut missing = L::ZERO;
        let rate = L::splat(pass.rate);
        for point in points.iter_mut() {
            let s = point.separation + point.approach(moved);
            let lack = -s.max(L::ZERO).mul_add(rate, point.approach(normals));
            let used = point.mass.select_above(L::ZERO, *lands, L::ZERO);
            point.now = lack.max(point.impulse).select_above(L::ZERO, used, L::ZERO);
            missing = point.now.mul_add(lack, missing);
            all = point.direction().scale_add(point.now, all);
        }
        let share = missing * all.dot(self.normals.apply(all)).inverse();
        for point in points.iter_mut() {
            point.give(point.now * share, normals, wrench);
        }
    }

    #[inline(always)]
    fn relax_normals_rigidly(
        &mut self,
        points: &mut [Points<L>],
        visit: &mut Visit<L>,
        pass: &Pass,
    ) {
        let mut normals = on_normals_local(&visit.velocity);
        let rate = L::splat(pass.rate);
        for point in points.iter_mut() {
            let approach = point.approach(&normals);
            let gap = point.now.select_above(point.reach, point.now, L::ZERO);
            let change = point.mass.taken_from(approach, -gap * (point.mass * rate));
            let given = point.give(change, &mut normals, &mut visit.wrench);
            visit.change = given.taken_from(approach, visit.change);
        }
    }
}

impl<L: F32xN> Visit<L> {
    /// What friction sees of what the normals have found.
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

    /// What normals see of what friction has found.
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
    /// Adds to λ_n, which stays ≥ 0; what of it was given.
    #[inline(always)]
    fn give(&mut self, change: L, normals: &mut Vec3xN<L>, wrench: &mut SpatialVec<L>) -> L {
        let given = change.max(-self.impulse);
        self.impulse += given;
        *normals = self.effect.scale_add(given, *normals);
        self.push(given, wrench);
        given
    }
}

impl<L: F32xN> Carried<L> {
    #[inline(always)]
    fn by(points: &[Points<L>]) -> Self {
        let (mut all, mut lever) = (L::ZERO, L::ZERO);
        for point in points {
            all += point.impulse;
            lever = point.impulse.mul_add(point.radius, lever);
        }
        Self { all, lever }
    }
}

#[inline(always)]
fn square_length<L: F32xN>([x, y]: [L; 2]) -> L {
    x.mul_add(x, y * y)
}

impl<L: F32xN> Hold<L> {
    const RIGID: Self = Self {
        mass_scale: L::ONE,
        impulse_scale: L::ZERO,
        back: [L::ZERO; 2],
        back_twist: L::ZERO,
    };
}
