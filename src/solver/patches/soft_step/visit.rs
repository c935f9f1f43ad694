//! One visit to a block: what its rows find, and what that does to the bodies.

use super::block::{Block, Pass, Points, on_normals_local};
use super::lanes::{Lane, Screw, State, Wide, gather};

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
struct Visit {
    /// Relative velocity in the patch's frame: (u_n, u_1, u_2) and (Ω_n, Ω_1, Ω_2).
    velocity: Screw,
    /// What the rows have found so far, in the same frame.
    wrench: Screw,
    /// Σ W Δλ² of the normals, J.
    change: Lane,
}

/// What the normals of a patch carry.
#[derive(Clone, Copy)]
struct Carried {
    /// Σλ_n, N·s.
    all: Lane,
    /// The same times the distances from the centre, N·m·s.
    lever: Lane,
}

/// How friction is held: as a spring about its anchor, or rigidly.
struct Hold {
    mass_scale: Lane,
    impulse_scale: Lane,
    /// Velocities that take the slip back, along the tangents and about the normal.
    back: [Lane; 2],
    back_twist: Lane,
}

impl Block {
    /// One projected Gauss–Seidel visit. With `SOFT` rows are springs and take errors back, friction before normals, which matter
    /// more. Without, they are rigid and only stop the motion, normals before friction, which so ends in its cone. The change
    /// of the normals, Σ W Δλ², J.
    #[inline(always)]
    pub fn relax<const SOFT: bool>(
        &mut self,
        points: &mut [Points],
        velocities: &mut [State],
        motions: &[State],
        pass: &Pass,
    ) -> Lane {
        let frame = self.frame();
        let a = gather(velocities, &self.bodies[0]);
        let b = gather(velocities, &self.bodies[1]);
        let mut visit = Visit {
            velocity: self.relative(&frame, a, b),
            wrench: Screw::default(),
            change: Lane::ZERO,
        };
        if SOFT {
            if !pass.first {
                self.account(points);
            }
            let moved_a = gather(motions, &self.bodies[0]);
            let moved_b = gather(motions, &self.bodies[1]);
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
    fn spring(&self, moved: &Screw) -> Hold {
        let rate = self.anchored * self.softness.bias_rate;
        let speed = self.max_speed;
        let back = |slip: Lane| (rate * slip).min(speed).max(-speed);
        Hold {
            mass_scale: Lane::ONE + self.anchored * (self.softness.mass_scale - Lane::ONE),
            impulse_scale: self.anchored * self.softness.impulse_scale,
            back: [
                back(self.slip[0] + moved.linear.y),
                back(self.slip[1] + moved.linear.z),
            ],
            back_twist: rate * (self.slip_twist + moved.angular.x),
        }
    }

    /// The most moment about the normal that friction gives, N·m·s.
    #[inline(always)]
    fn most_twist(&self, carried: &Carried) -> Lane {
        self.friction * carried.lever + self.rolling_lever * carried.all
    }

    /// What slides takes its anchor along. The springs of friction, or their place where none is set yet, stretch no farther than the
    /// patch can hold them with what it carries. Else what slides and stops inside one step, and so counts as sticking, would be
    /// drawn back by all that it slid.
    #[inline(always)]
    fn drag(&mut self, carried: &Carried, moved: &Screw) {
        let pull = [
            self.compliance * self.held[0] - self.slip[0] - moved.linear.y,
            self.compliance * self.held[1] - self.slip[1] - moved.linear.z,
        ];
        let pull_twist =
            self.compliance_twist * self.held_twist - self.slip_twist - moved.angular.x;
        let square = pull[0] * pull[0] + pull[1] * pull[1];
        let angle = pull_twist.max(-pull_twist);
        let play = Lane::splat(PLAY);
        if !square.any_above(play * play) && !(angle * self.radius).any_above(play) {
            return;
        }
        let length = square.sqrt();
        let limit = self.most_twist(carried);
        let reach = self.compliance_twist * limit + play * self.radius.inverse();
        let cut = (reach * angle.inverse()).min(Lane::ONE) - Lane::ONE;
        self.slip_twist -= cut * pull_twist;
        self.dragged_twist += cut * pull_twist;

        let reach = self.compliance * self.friction * carried.all + play;
        let cut = (reach * length.inverse()).min(Lane::ONE) - Lane::ONE;
        for (i, pull) in pull.into_iter().enumerate() {
            self.slip[i] -= cut * pull;
            self.dragged[i] += cut * pull;
        }
    }

    /// Twist, then both tangents, within what the normals carry now.
    #[inline(always)]
    fn relax_friction(&mut self, carried: &Carried, visit: &mut Visit, hold: &Hold) {
        let keep = Lane::ONE - hold.impulse_scale;

        let limit = self.most_twist(carried);
        let excess = visit.velocity.angular.x + hold.back_twist;
        let found = self.twist * keep + hold.impulse_scale * self.held_twist
            - self.twist_mass * hold.mass_scale * excess;
        let found = found.min(limit).max(-limit);
        let twist = found - self.twist;
        self.twist = found;

        let limit = self.friction * carried.all;
        let excess = [
            visit.velocity.linear.y + self.twist_to_tangents[0] * twist + hold.back[0],
            visit.velocity.linear.z + self.twist_to_tangents[1] * twist + hold.back[1],
        ];
        // The exact step where it stays inside the cone, else an isotropic one, projected (see `rows.rs`).
        let [xx, yy, xy] = self.tangent_mass;
        let start = [
            self.tangential[0] * keep + hold.impulse_scale * self.held[0],
            self.tangential[1] * keep + hold.impulse_scale * self.held[1],
        ];
        let mut found = [
            start[0] - hold.mass_scale * (xx * excess[0] + xy * excess[1]),
            start[1] - hold.mass_scale * (xy * excess[0] + yy * excess[1]),
        ];
        let square = found[0] * found[0] + found[1] * found[1];
        let limit_square = limit * limit;
        if square.any_above(limit_square) {
            let isotropic = hold.mass_scale * self.isotropic_mass;
            let slid = [
                start[0] - isotropic * excess[0],
                start[1] - isotropic * excess[1],
            ];
            let length = (slid[0] * slid[0] + slid[1] * slid[1]).sqrt();
            let shorten = length.above(limit, limit * length.inverse(), Lane::ONE);
            found = [
                square.above(limit_square, slid[0] * shorten, found[0]),
                square.above(limit_square, slid[1] * shorten, found[1]),
            ];
        }
        let change = [found[0] - self.tangential[0], found[1] - self.tangential[1]];
        self.tangential = found;

        visit.wrench.linear.y += change[0];
        visit.wrench.linear.z += change[1];
        visit.wrench.angular.x += twist;
    }

    /// Soft friction was found for what normals carried before them. Where they have let go since, as after a blow, friction of the
    /// blow would be given twice.
    #[inline(always)]
    fn confine(&mut self, carried: &Carried, visit: &mut Visit) {
        let limit = Lane::splat(STALE) * self.friction * carried.all;
        let [x, y] = self.tangential;
        let square = x * x + y * y;
        if !square.any_above(limit * limit) {
            return;
        }
        let length = square.sqrt();
        let shorten = length.above(limit, limit * length.inverse(), Lane::ONE);
        self.tangential = [x * shorten, y * shorten];
        visit.wrench.linear.y += self.tangential[0] - x;
        visit.wrench.linear.z += self.tangential[1] - y;
    }

    /// What creeps is stopped: Ω_1 and Ω_2 together, within what the normals carry now, and less where it is faster.
    fn relax_rolling(&mut self, carried: &Carried, visit: &mut Visit) {
        let spin = [visit.velocity.angular.y, visit.velocity.angular.z];
        let slip = [visit.velocity.linear.y, visit.velocity.linear.z];
        let rolling = self.rolling_radius * self.rolling_radius;
        let square = rolling * (spin[0] * spin[0] + spin[1] * spin[1])
            + (slip[0] * slip[0] + slip[1] * slip[1]);
        let fast = Lane::ONE + square * Lane::splat(1.0 / (CREEP * CREEP));
        let limit = self.rolling_lever * carried.all * (fast * fast).inverse();
        let [xx, yy, xy] = self.rolling_mass;
        let exact = [
            self.rolling[0] - (xx * spin[0] + xy * spin[1]),
            self.rolling[1] - (xy * spin[0] + yy * spin[1]),
        ];
        let length = (exact[0] * exact[0] + exact[1] * exact[1]).sqrt();
        let shorten = length.above(limit, limit * length.inverse(), Lane::ONE);
        let found = exact.map(|moment| moment * shorten);
        let change = [found[0] - self.rolling[0], found[1] - self.rolling[1]];
        self.rolling = found;

        visit.wrench.angular.y += change[0];
        visit.wrench.angular.z += change[1];
        let seen = self.normals.apply(Wide {
            x: Lane::ZERO,
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
        points: &mut [Points],
        carried: &Carried,
        visit: &mut Visit,
        moved: &Wide,
        pass: &Pass,
    ) {
        let soft = &self.softness;
        let mean = carried.all * self.share;
        // The share of its load that the patch still carries, and what of it is held at most.
        let left = mean * self.inverse_load;
        let most = (left * Lane::splat(UNLOADED)).min(Lane::ONE);
        let left = left.min(Lane::ONE);
        let mut normals = on_normals_local(&visit.velocity);
        // 1 where it lands. The patches beside it must find what they would find alone.
        let landing = Lane::splat(LANDING);
        let speed = normals.x.max(-normals.x);
        let mut counts = Lane::ONE;
        let visits = if speed.any_above(landing) {
            let lands = speed.above(landing, Lane::ONE, Lane::ZERO);
            self.stop_together(points, &lands, &mut normals, &mut visit.wrench, moved, pass);
            LANDING_VISITS
        } else {
            1
        };
        for _ in 0..visits {
            for point in points.iter_mut() {
                let along = point.direction();
                let approach = along.dot(normals);
                let s = point.separation + along.dot(*moved);
                point.now = s;
                let push = (-soft.bias_rate * s).min(self.max_speed);
                let load = point.load * most;
                let lost = (point.load * left - point.impulse).max(Lane::ZERO);
                let held = load - pass.preload * lost;
                point.reach = load * point.compliance;
                let closed = soft.mass_scale * point.mass * (approach - push)
                    + soft.impulse_scale * (point.impulse - held);
                let apart = point.mass * (approach + s * pass.rate);
                let step = counts * s.above(point.reach, apart, closed);
                visit.change -= point.give(-step, &mut normals, &mut visit.wrench) * approach;
            }
            counts = speed.above(landing, Lane::ONE, Lane::ZERO);
        }
    }

    /// What lands on a face, or still has the impulse of landing, would be turned by the point that is visited first. So all its
    /// points are stopped together before.
    #[cold]
    fn stop_together(
        &self,
        points: &mut [Points],
        lands: &Lane,
        normals: &mut Wide,
        wrench: &mut Screw,
        moved: &Wide,
        pass: &Pass,
    ) {
        let mut all = Wide::default();
        let mut missing = Lane::ZERO;
        for point in points.iter_mut() {
            let along = point.direction();
            let s = point.separation + along.dot(*moved);
            let lack = -(along.dot(*normals) + s.max(Lane::ZERO) * pass.rate);
            let used = point.mass.above(Lane::ZERO, *lands, Lane::ZERO);
            point.now = lack.max(point.impulse).above(Lane::ZERO, used, Lane::ZERO);
            missing += point.now * lack;
            all = all + along.scale(point.now);
        }
        let share = missing * all.dot(self.normals.apply(all)).inverse();
        for point in points.iter_mut() {
            point.give(point.now * share, normals, wrench);
        }
    }

    #[inline(always)]
    fn relax_normals_rigidly(&mut self, points: &mut [Points], visit: &mut Visit, pass: &Pass) {
        let mut normals = on_normals_local(&visit.velocity);
        for point in points.iter_mut() {
            let approach = point.direction().dot(normals);
            let gap = point.now.above(point.reach, point.now, Lane::ZERO);
            let step = point.mass * (approach + gap * pass.rate);
            visit.change -= point.give(-step, &mut normals, &mut visit.wrench) * approach;
        }
    }
}

impl Visit {
    /// What friction sees of what the normals have found.
    #[inline(always)]
    fn follow_normals(&mut self, block: &Block) {
        let given = Wide {
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
    fn follow_friction(&mut self, block: &Block) {
        let on_normals = block.twist_to_normals.scale(self.wrench.angular.x)
            + block.tangents_to_normals[0].scale(self.wrench.linear.y)
            + block.tangents_to_normals[1].scale(self.wrench.linear.z);
        self.velocity.linear.x += on_normals.x;
        self.velocity.angular.y += on_normals.y;
        self.velocity.angular.z += on_normals.z;
    }
}

impl Points {
    /// Adds to λ_n, which stays ≥ 0; what of it was given.
    #[inline(always)]
    fn give(&mut self, change: Lane, normals: &mut Wide, wrench: &mut Screw) -> Lane {
        let found = (self.impulse + change).max(Lane::ZERO);
        let given = found - self.impulse;
        self.impulse = found;
        *normals = *normals + self.effect.scale(given);
        wrench.linear.x += given;
        wrench.angular.y += self.y * given;
        wrench.angular.z -= self.x * given;
        given
    }
}

impl Carried {
    #[inline(always)]
    fn by(points: &[Points]) -> Self {
        let (mut all, mut lever) = (Lane::ZERO, Lane::ZERO);
        for point in points {
            all += point.impulse;
            lever += point.impulse * point.radius;
        }
        Self { all, lever }
    }
}

impl Hold {
    const RIGID: Self = Self {
        mass_scale: Lane::ONE,
        impulse_scale: Lane::ZERO,
        back: [Lane::ZERO; 2],
        back_twist: Lane::ZERO,
    };
}
