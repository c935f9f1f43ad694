//! A patch as terms of an augmented Lagrangian: a normal row for each point, two friction rows and a twist row at the centre.
//!
//! A row with the error C (m, rad), the stiffness k and the force λ acts with λ⁺ = λ − k C, limited to what contact can do: λ⁺ ≥ 0 for
//! normals, ‖λ⁺‖ ≤ μ Σ λ_n for friction, |λ⁺| ≤ μ Σ λ_n ‖offset‖ for the twist. (The paper has the opposite sign of λ.) A primal update
//! moves bodies with this law; a dual update sets λ ← λ⁺ and k ← k + β |C| where no limit was reached.

use super::Avbd;
use drystone::solver::{PatchConstraint, PatchPoint, PatchProblem, tangents};
use glam::{Mat3, Vec2, Vec3};

/// Displacement of the centre of mass (m) and rotation (rad) of a body since the start of the step, world axes.
pub type Move = [Vec3; 2];

/// A constraint row, or two that share a stiffness.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// The stiffness k, as a share of `unit`.
    stiffness: f32,
    /// The effective mass of the row over h²: N/m, or N·m/rad for the twist.
    unit: f32,
    /// Growth of the stiffness per error, 1/m, or 1/rad for the twist.
    growth: f32,
}

/// One point of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// From the patch's centre along both tangents, m.
    offset: Vec2,
    /// C at the start of the step, with the share of an overlap that is taken back in this step, m.
    gap: f32,
    /// λ_n, N.
    force: f32,
    row: Row,
}

/// A patch. World axes, if nothing else is said.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Indices of A and B among the problem's bodies.
    pub bodies: [u32; 2],
    /// n, t1, t2.
    axes: [Vec3; 3],
    /// From the centres of mass of A and B to the patch's centre, m.
    arms: [Vec3; 2],
    /// The components of the arms along both tangents, m.
    flat_arms: [Vec2; 2],
    friction: f32,
    /// Slip at the start of the step along both tangents, m, and about the normal, rad: the share that is taken back in this step.
    slip: Vec2,
    twist: f32,
    /// λ_t, N, and the moment about the normal, N·m.
    tangential: Vec2,
    moment: f32,
    rows: [Row; 2],
    /// Its points among all.
    points: std::ops::Range<usize>,
}

/// What a patch does at a relative motion of its bodies, in its frame.
struct Reaction {
    /// Σ λ_n⁺, N.
    normal: f32,
    /// Σ λ_n⁺ offset, N·m.
    lever: Vec2,
    tangential: Vec2,
    moment: f32,
    /// Stiffness of normals that are loaded or were at the last dual update: Σ k, Σ k offset, and Σ k offset offsetᵀ by its elements 11,
    /// 12 and 22.
    stiffness: f32,
    first: Vec2,
    second: [f32; 3],
    /// Stiffness of friction, N/m, and of the twist, N·m/rad. It decreases where a limit is reached.
    along: f32,
    about: f32,
}

/// The stiffnesses that are kept from step to step, as shares of the units: of the points, and of friction and twist of the patches.
#[derive(Debug, Default)]
pub struct Stiffness {
    points: Vec<f32>,
    patches: Vec<[f32; 2]>,
}

impl Stiffness {
    /// The stiffnesses at the end of a step.
    pub fn of(contacts: &[Contact], points: &[Point]) -> Self {
        Self {
            points: points.iter().map(|point| point.row.stiffness).collect(),
            patches: contacts
                .iter()
                .map(|contact| contact.rows.map(|row| row.stiffness))
                .collect(),
        }
    }
}

/// Prepares all patches of a problem: forces are the warm start times α γ, stiffnesses those of the last step times γ.
pub fn prepare(
    problem: &PatchProblem,
    settings: &Avbd,
    kept: Option<&Stiffness>,
) -> (Vec<Contact>, Vec<Point>) {
    let mut points = Vec::with_capacity(problem.points.len());
    let mut contacts = Vec::with_capacity(problem.patches.len());
    let surfaces = &mut problem.surfaces.iter().peekable();
    for (i, patch) in problem.patches.iter().enumerate() {
        let moving = surfaces.next_if(|(patch, _)| *patch as usize == i);
        let surface = moving.map_or(Vec3::ZERO, |(_, velocity)| *velocity);
        contacts.push(Contact::new(
            problem,
            settings,
            patch,
            kept.map(|kept| kept.patches[i]),
            surface,
            points.len(),
        ));
        for at in patch.range() {
            let last = kept.map(|kept| kept.points[at]);
            points.push(Point::new(
                problem,
                settings,
                patch,
                &problem.points[at],
                last,
            ));
        }
    }
    (contacts, points)
}

/// The way of free fall in a step, g h², m. Where there is next to no gravity it is that under 1 m/s².
fn fall(problem: &PatchProblem) -> f32 {
    problem.gravity.length().max(1.0) * problem.dt * problem.dt
}

/// The stiffness to start from, as a share of the unit.
fn first_stiffness(settings: &Avbd, last: Option<f32>) -> f32 {
    let least = settings.first_stiffness;
    last.map_or(least, |last| (settings.gamma * last).max(least))
}

impl Point {
    fn new(
        problem: &PatchProblem,
        settings: &Avbd,
        patch: &PatchConstraint,
        point: &PatchPoint,
        last: Option<f32>,
    ) -> Self {
        let h = problem.dt;
        let [t1, t2] = tangents(patch.normal);
        let response = |side: usize| {
            let body = &problem.bodies[patch.bodies[side] as usize];
            body.response(patch.normal, patch.arms[side] + point.offset)
        };
        Self {
            offset: Vec2::new(t1.dot(point.offset), t2.dot(point.offset)),
            gap: match point.separation < 0.0 {
                true => (settings.share_taken_back() * point.separation)
                    .max(-problem.max_correction_speed * h),
                false => point.separation,
            },
            force: settings.alpha * settings.gamma * point.normal_impulse / h,
            row: Row::new(settings, response(0) + response(1), h, fall(problem), last),
        }
    }

    /// λ⁺, N, if this is the error.
    #[inline]
    fn pressed(&self, error: f32) -> f32 {
        (self.force - self.row.k() * error).max(0.0)
    }

    /// The error at a relative motion at the patch's centre (m) and a relative rotation (rad), in the patch's frame.
    #[inline]
    fn error(&self, shift: Vec3, turn: Vec3) -> f32 {
        self.gap + shift.x + self.offset.y * turn.y - self.offset.x * turn.z
    }

    /// λ_n, N.
    pub fn force(&self) -> f32 {
        self.force
    }

    /// Half the energy that a contact would take out of a motion to stop it if it were alone, J, if its bodies move by `shift` and `turn`
    /// at the patch's centre.
    fn missing(&self, shift: Vec3, turn: Vec3) -> f32 {
        self.row.unit * self.error(shift, turn).min(0.0).powi(2)
    }
}

impl Row {
    /// `response` is the inverse effective mass, 1/kg or 1/(kg·m²); an error of `fall` (m or rad) lets the stiffness grow by β.
    fn new(settings: &Avbd, response: f32, h: f32, fall: f32, last: Option<f32>) -> Self {
        Self {
            growth: settings.beta / fall,
            stiffness: first_stiffness(settings, last),
            unit: match response > 0.0 {
                true => 1.0 / (h * h * response),
                false => 0.0,
            },
        }
    }

    /// k, N/m or N·m/rad.
    #[inline]
    fn k(&self) -> f32 {
        self.stiffness * self.unit
    }

    /// k ← k + β |C|.
    fn grow(&mut self, settings: &Avbd, error: f32) {
        let grown = self.stiffness + self.growth * error.abs();
        self.stiffness = grown.min(settings.max_stiffness);
    }
}

impl Contact {
    fn new(
        problem: &PatchProblem,
        settings: &Avbd,
        patch: &PatchConstraint,
        last: Option<[f32; 2]>,
        surface: Vec3,
        first: usize,
    ) -> Self {
        let (h, normal) = (problem.dt, patch.normal);
        let [t1, t2] = tangents(normal);
        let flat = |v: Vec3| Vec2::new(t1.dot(v), t2.dot(v));
        let pair = patch.bodies.map(|body| &problem.bodies[body as usize]);
        let response = |axis: Vec3| {
            pair[0].response(axis, patch.arms[0]) + pair[1].response(axis, patch.arms[1])
        };
        let about = normal.dot((pair[0].inverse_inertia + pair[1].inverse_inertia) * normal);
        let slip = patch.slip.unwrap_or_default();
        let (share, scale) = (
            settings.share_taken_back(),
            settings.alpha * settings.gamma / h,
        );
        // The mean of both tangents.
        let along = 0.5 * (response(t1) + response(t2));
        // Over the radius of gyration.
        let turn = fall(problem) * (about / along.max(f32::MIN_POSITIVE)).sqrt();
        let row = |response: f32, error: f32, i: usize| {
            Row::new(settings, response, h, error, last.map(|k| k[i]))
        };
        Self {
            bodies: patch.bodies,
            axes: [normal, t1, t2],
            arms: patch.arms,
            flat_arms: patch.arms.map(flat),
            friction: patch.friction,
            slip: share * flat(slip.shift) - h * flat(surface),
            twist: share * slip.twist,
            tangential: scale * flat(patch.friction_impulse),
            moment: scale * patch.twist_impulse,
            rows: [row(along, fall(problem), 0), row(about, turn.max(1e-9), 1)],
            points: first..first + patch.count as usize,
        }
    }

    /// Motion of A relative to B at the centre (m) and rotation (rad), in the frame (n, t1, t2).
    #[inline]
    fn relative(&self, moves: &[Move]) -> [Vec3; 2] {
        let [a, b] = self.bodies.map(|body| moves[body as usize]);
        let shift = a[0] - b[0] + a[1].cross(self.arms[0]) - b[1].cross(self.arms[1]);
        [shift, a[1] - b[1]].map(|v| self.in_frame(v))
    }

    #[inline]
    fn in_frame(&self, v: Vec3) -> Vec3 {
        Vec3::from_array(self.axes.map(|axis| axis.dot(v)))
    }

    #[inline]
    fn in_world(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    fn react(&self, points: &[Point], [shift, turn]: [Vec3; 2]) -> Reaction {
        let mut reaction = Reaction {
            normal: 0.0,
            lever: Vec2::ZERO,
            tangential: Vec2::ZERO,
            moment: 0.0,
            stiffness: 0.0,
            first: Vec2::ZERO,
            second: [0.0; 3],
            along: 0.0,
            about: 0.0,
        };
        let mut spread = 0.0;
        for point in &points[self.points.clone()] {
            let force = point.pressed(point.error(shift, turn));
            if force > 0.0 || point.force > 0.0 {
                let (k, offset) = (point.row.k(), point.offset);
                reaction.normal += force;
                reaction.lever += force * offset;
                spread += force * offset.length();
                reaction.stiffness += k;
                reaction.first += k * offset;
                reaction.second[0] += k * offset.x * offset.x;
                reaction.second[1] += k * offset.x * offset.y;
                reaction.second[2] += k * offset.y * offset.y;
            }
        }
        let [along, about] = self.rows.map(|row| row.k());
        let slip = self.slip + Vec2::new(shift.y, shift.z);
        let (tangential, share) = limited(
            self.tangential - along * slip,
            self.friction * reaction.normal,
        );
        (reaction.tangential, reaction.along) = (tangential, share * along);
        let wanted = Vec2::X * (self.moment - about * (self.twist + turn.x));
        let (moment, share) = limited(wanted, self.friction * spread);
        (reaction.moment, reaction.about) = (moment.x, share * about);
        reaction
    }

    /// Force (N) and torque (N·m) on A or B (`side` 0 or 1) at the current motions, and their negative derivatives: by a displacement; by a
    /// rotation (row) and a displacement (column); by a rotation.
    pub fn act(&self, points: &[Point], moves: &[Move], side: usize) -> ([Vec3; 2], [Mat3; 3]) {
        let reaction = self.react(points, self.relative(moves));
        let [n, t1, t2] = self.axes;
        let arm = self.arms[side];
        let Vec2 { x, y } = reaction.tangential;
        let force = self.in_world(Vec3::new(reaction.normal, x, y));
        // Σ λ offset × n, with t2 × n = t1 and t1 × n = −t2.
        let turning = Vec3::new(reaction.moment, reaction.lever.y, -reaction.lever.x);
        let torque = arm.cross(force) + self.in_world(turning);
        let sign = if side == 0 { 1.0 } else { -1.0 };

        // Of normal rows, whose levers about the body's centre are (arm + offset) × n.
        let flat = self.flat_arms[side];
        let Reaction {
            stiffness: k,
            first,
            second: [xx, xy, yy],
            along,
            about,
            ..
        } = reaction;
        let q = first + k * flat;
        let shifted = [
            xx + flat.x * (first.x + q.x),
            xy + flat.x * first.y + flat.y * q.x,
            yy + flat.y * (first.y + q.y),
        ];
        let lever = t1 * q.y - t2 * q.x;
        // Friction rows act at the centre, along all of the plane: their sum over both tangents needs none of them.
        let across = arm.cross(n);
        let linear = outer((k - along) * n, n) + Mat3::from_diagonal(Vec3::splat(along));
        let cross = outer(lever - along * across, n) + along * skew(arm);
        let angular = outer(shifted[2] * t1 - shifted[1] * t2, t1)
            + outer(shifted[0] * t2 - shifted[1] * t1, t2)
            + along
                * (Mat3::from_diagonal(Vec3::splat(arm.length_squared()))
                    - outer(arm, arm)
                    - outer(across, across))
            + outer(about * n, n);
        ([sign * force, sign * torque], [linear, cross, angular])
    }

    /// The dual update: λ ← λ⁺, and k ← k + β |C| where no limit was reached.
    pub fn update(&mut self, points: &mut [Point], moves: &[Move], settings: &Avbd) {
        let [shift, turn] = self.relative(moves);
        let reaction = self.react(points, [shift, turn]);
        let mut spread = 0.0;
        for point in &mut points[self.points.clone()] {
            let error = point.error(shift, turn);
            point.force = point.pressed(error);
            spread += point.force * point.offset.length();
            if point.force > 0.0 {
                point.row.grow(settings, error);
            }
        }
        (self.tangential, self.moment) = (reaction.tangential, reaction.moment);
        let slip = self.slip + Vec2::new(shift.y, shift.z);
        if self.tangential.length() < self.friction * reaction.normal {
            self.rows[0].grow(settings, slip.length());
        }
        if self.moment.abs() < self.friction * spread {
            self.rows[1].grow(settings, self.twist + turn.x);
        }
    }

    /// The energy that normals would take out of a motion if each were alone, J, times 2.
    pub fn missing(&self, points: &[Point], moves: &[Move]) -> f32 {
        let [shift, turn] = self.relative(moves);
        let points = &points[self.points.clone()];
        points.iter().map(|point| point.missing(shift, turn)).sum()
    }

    /// The sum of the forces of its normals on A along n, N.
    pub fn pressure(&self, points: &[Point]) -> Vec3 {
        let points = &points[self.points.clone()];
        self.axes[0] * points.iter().map(|point| point.force).sum::<f32>()
    }

    /// Friction force on A, N, and moment about the normal, N·m.
    pub fn friction(&self) -> (Vec3, f32) {
        let Vec2 { x, y } = self.tangential;
        (self.axes[1] * x + self.axes[2] * y, self.moment)
    }

    /// Whether friction force and twist are at their limits, so that the patch slides or turns.
    pub fn slides(&self, points: &[Point]) -> [bool; 2] {
        let points = &points[self.points.clone()];
        let normal: f32 = points.iter().map(|point| point.force).sum();
        let spread: f32 = points
            .iter()
            .map(|point| point.force * point.offset.length())
            .sum();
        // To rounding.
        let limit = (1.0 - 1e-5) * self.friction;
        [
            self.tangential.length() >= limit * normal,
            self.moment.abs() >= limit * spread,
        ]
    }

    /// Motion of A on B along the surface, world axes, m, and about the normal, rad.
    pub fn moved(&self, moves: &[Move]) -> (Vec3, f32) {
        let [shift, turn] = self.relative(moves);
        (self.axes[1] * shift.y + self.axes[2] * shift.z, turn.x)
    }
}

/// The nearest vector that is no longer than `limit`, and its length as a share of the given one's.
#[inline]
fn limited(force: Vec2, limit: f32) -> (Vec2, f32) {
    let length = force.length();
    if length <= limit {
        return (force, 1.0);
    }
    let share = limit / length;
    (share * force, share)
}

/// a bᵀ.
#[inline]
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The matrix of a × .
#[inline]
fn skew(a: Vec3) -> Mat3 {
    Mat3::from_cols(
        Vec3::new(0.0, a.z, -a.y),
        Vec3::new(-a.z, 0.0, a.x),
        Vec3::new(a.y, -a.x, 0.0),
    )
}
