//! Augmented vertex block descent (Giles, Diaz, Yuksel 2025, "Augmented Vertex Block Descent", ACM Transactions on Graphics 44/4), for
//! rigid bodies in contact.
//!
//! A step of implicit Euler minimizes ½ (x − y)ᵀ M (x − y)/h² plus the energy of all constraints, where y is the inertial position. *Vertex
//! block descent* visits one body after the other, and takes a Newton step of its six coordinates while the others stand still ([`block`]).
//! The energy of a hard constraint is an augmented Lagrangian, ½ k C² + λ C ([`contact`]). After each sweep over all bodies λ takes over
//! the force k C, and k grows by β |C|, so that constraints become hard within a few steps and soft ones do not stall the others.
//!
//! - **Inequalities**: forces of normals are not negative, and friction is limited by the normal forces. Rows at a limit do not get
//!   stiffer.
//! - **Warm start**: a step begins with α γ λ and γ k of the last one.
//! - **Errors from before the step**: only the share 1 − α of an overlap or a slip is taken back in a step, so that it does not become a
//!   velocity. Gaps are closed as far as they are.
//! - **First guess**: bodies move on with the part of gravity that the warm start leaves them, none to all of it.
//! - **Velocities** are the displacements over h.
//!
//! Where this differs from the paper:
//!
//! - The trait gives patches, each with one friction force and one twist at its centre. The paper has friction at every point.
//! - Stiffness is in units of a row's effective mass over h², and β |C| in units of the way of free fall in a step, so that masses, sizes
//!   and steps do not change the settings. With stiffness that grows ten times as fast, forces overshoot and towers of 20 are thrown up.
//! - Friction at its limit adds less stiffness to the Newton step, as the derivative of its force is, and a normal that neither is loaded
//!   nor was at the last dual update adds none. Otherwise a sliding or flying body would be braked by rows that cannot hold it. (A normal
//!   that has just been unloaded keeps its stiffness, as in the paper: without it towers of 20 are thrown up.)
//! - Arms and normals are those of the start of the step, as for every solver of this trait. So contacts have no second derivatives, and
//!   need none of the paper's geometric stiffness.
//!
//! Restitution, rolling friction, joints and grabs are left out: [`Scene::has_contacts_only`](crate::scenes::Scene::has_contacts_only)
//! tells which scenes can do without.
//!
//! The forces are warm started by the trait. Stiffnesses are in [`Memory`](drystone::solver::Memory), which forgets them where a contact
//! of the island begins or ends; they begin anew then.

mod block;
mod contact;

use block::{Block, Inertia};
use contact::{Contact, Move, Point, Stiffness, prepare};
use drystone::settings::ContactSolver;
use drystone::solver::{PatchProblem, PatchSolver, Slip, SolveReport};
use glam::Vec3;
use std::sync::Arc;

/// The augmented vertex block descent solver, a patch solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Avbd {
    /// Number of sweeps over all bodies in a step.
    pub iterations: usize,
    /// Share of an error from before the step that is left for later steps, 0..1.
    pub alpha: f32,
    /// Growth of a row's stiffness in a sweep, as a share of its effective mass over h², if its error is the way of free fall in a step,
    /// g h². Larger errors make it grow faster.
    pub beta: f32,
    /// Share of the last step's stiffness, and with α of its forces, that a step starts from, 0..1.
    pub gamma: f32,
    /// Least stiffness of a row, as a share of its effective mass over h².
    pub first_stiffness: f32,
    /// Largest stiffness of a row, as a share of its effective mass over h².
    pub max_stiffness: f32,
}

impl Default for Avbd {
    fn default() -> Self {
        Self {
            iterations: 10,
            alpha: 0.95,
            beta: 1.0,
            gamma: 0.99,
            first_stiffness: 5.0,
            max_stiffness: 1e4,
        }
    }
}

impl From<Avbd> for ContactSolver {
    fn from(solver: Avbd) -> Self {
        Self::Patches(Arc::new(solver))
    }
}

impl Avbd {
    /// Share of an error from before the step that is taken back in the step.
    fn share_taken_back(&self) -> f32 {
        1.0 - self.alpha
    }
}

impl PatchSolver for Avbd {
    fn name(&self) -> &str {
        "avbd"
    }

    fn problem(&self) -> Option<String> {
        if self.iterations == 0 {
            return Some("iterations is 0, and must be at least 1".into());
        }
        let bounds = [
            ("alpha", self.alpha, 0.0, 1.0),
            ("beta", self.beta, 0.0, f32::MAX),
            ("gamma", self.gamma, 0.0, 1.0),
            ("first_stiffness", self.first_stiffness, 1e-6, 1e6),
            (
                "max_stiffness",
                self.max_stiffness,
                self.first_stiffness,
                1e6,
            ),
        ];
        let wrong = bounds
            .into_iter()
            .find(|(_, value, least, most)| !(least..=most).contains(&value));
        wrong.map(|(name, value, least, most)| {
            format!("{name} is {value}, and must be between {least} and {most}")
        })
    }

    fn solve(&self, problem: &mut PatchProblem) -> SolveReport {
        let kept = problem.memory.take::<Stiffness>();
        let mut descent = Descent::new(self, problem, kept.as_deref());
        let mut report = SolveReport::new(descent.free_merit(), problem.record_history);
        let sweeps = (self.iterations as f32 * problem.effort).round() as usize;
        for _ in 0..sweeps {
            report.record(descent.sweep().sqrt());
            for contact in &mut descent.contacts {
                contact.update(&mut descent.points, &descent.moves, self);
            }
        }
        descent.store(problem);
        let stiffness = Stiffness::of(&descent.contacts, &descent.points);
        problem.memory.keep(Box::new(stiffness));
        report
    }
}

/// A step of one island.
struct Descent {
    contacts: Vec<Contact>,
    points: Vec<Point>,
    /// By body; `None` for bodies that nothing moves.
    inertia: Vec<Option<Inertia>>,
    /// The inertial positions y, and the current ones x, as motions since the start of the step.
    inertial: Vec<Move>,
    moves: Vec<Move>,
    /// By body: where its patches begin in `touching`.
    firsts: Vec<usize>,
    /// Patches with the side on which the body is.
    touching: Vec<(u32, u8)>,
    /// s
    h: f32,
}

impl Descent {
    fn new(settings: &Avbd, problem: &PatchProblem, kept: Option<&Stiffness>) -> Self {
        let (contacts, points) = prepare(problem, settings, kept);
        let h = problem.dt;
        let bodies = &*problem.bodies;
        let mut forces = vec![Vec3::ZERO; bodies.len()];
        let mut firsts = vec![0; bodies.len() + 1];
        for contact in &contacts {
            let force = contact.pressure(&points) + contact.friction().0;
            for (&body, sign) in contact.bodies.iter().zip([1.0, -1.0]) {
                forces[body as usize] += sign * force;
                firsts[body as usize + 1] += 1;
            }
        }
        for body in 0..bodies.len() {
            firsts[body + 1] += firsts[body];
        }
        let mut touching = vec![(0, 0); firsts[bodies.len()]];
        let mut next = firsts.clone();
        for (i, contact) in contacts.iter().enumerate() {
            for (&body, side) in contact.bodies.iter().zip([0, 1]) {
                let place = &mut next[body as usize];
                touching[*place] = (i as u32, side);
                *place += 1;
            }
        }
        let (down, gravity) = (
            problem.gravity.normalize_or_zero(),
            problem.gravity.length(),
        );
        let moves = bodies.iter().zip(&forces).map(|(body, &force)| {
            if body.inverse_mass == 0.0 {
                return [h * body.linear, h * body.angular];
            }
            let acceleration = body.push()[0] / h + body.inverse_mass * force;
            let fall = down.dot(acceleration).clamp(0.0, gravity);
            let velocity = body.start[0] + h * fall * down * body.free_axes;
            [h * velocity, h * body.start[1]]
        });
        Self {
            inertia: bodies.iter().map(|body| Inertia::new(body, h)).collect(),
            inertial: bodies
                .iter()
                .map(|body| [h * body.linear, h * body.angular])
                .collect(),
            moves: moves.collect(),
            contacts,
            points,
            firsts,
            touching,
            h,
        }
    }

    /// Takes a Newton step of each body in turn. Returns Σ Δᵀ M Δ/h² of all steps, J.
    fn sweep(&mut self) -> f32 {
        let mut change = 0.0;
        for (body, inertia) in self.inertia.iter().enumerate() {
            let Some(inertia) = inertia else {
                continue;
            };
            let [at, rest] = [self.moves[body], self.inertial[body]];
            let mut block = Block::new(inertia, [at[0] - rest[0], at[1] - rest[1]]);
            for &(contact, side) in &self.touching[self.firsts[body]..self.firsts[body + 1]] {
                let contact = &self.contacts[contact as usize];
                let (forces, derivatives) = contact.act(&self.points, &self.moves, side as usize);
                block.add(forces, derivatives);
            }
            let step = block.solve(inertia);
            self.moves[body] = [at[0] + step[0], at[1] + step[1]];
            change += inertia.square(step);
        }
        change
    }

    /// The merit of the free motion, √J: what all normals would take out of it, if each were alone. See [`drystone::solver::merit`].
    fn free_merit(&self) -> f32 {
        let contacts = self.contacts.iter();
        let missing = contacts.map(|contact| contact.missing(&self.points, &self.inertial));
        missing.sum::<f32>().sqrt()
    }

    /// Writes velocities, impulses and slips to the problem.
    fn store(&self, problem: &mut PatchProblem) {
        let h = self.h;
        for ((body, moved), inertia) in problem
            .bodies
            .iter_mut()
            .zip(&self.moves)
            .zip(&self.inertia)
        {
            if inertia.is_some() {
                [body.linear, body.angular] = moved.map(|way| way / h);
            }
            body.motion = Some([body.linear, body.angular]);
        }
        for (point, solved) in problem.points.iter_mut().zip(&self.points) {
            let impulse = h * solved.force();
            point.normal_impulse = impulse;
            point.normal = impulse;
            point.rest_impulse = impulse;
        }
        for (patch, contact) in problem.patches.iter_mut().zip(&self.contacts) {
            let (force, moment) = contact.friction();
            patch.friction_impulse = h * force;
            patch.twist_impulse = h * moment;
            patch.tangential = patch.friction_impulse;
            patch.rest_friction_impulse = patch.friction_impulse;
            patch.rest_twist_impulse = patch.twist_impulse;
            // Where a patch slides, its anchor goes with it.
            if let Some(slip) = patch.slip {
                let (shift, twist) = contact.moved(&self.moves);
                let [slides, turns] = contact.slides(&self.points);
                patch.dragged = Slip {
                    shift: if slides {
                        slip.shift + shift
                    } else {
                        Vec3::ZERO
                    },
                    twist: if turns { slip.twist + twist } else { 0.0 },
                };
            }
        }
    }
}
