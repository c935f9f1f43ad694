//! Walls: bodies through which no grab can pull a held body. These are fixed bodies, and bodies that lean against one on their other side.
//!
//! Contacts are springs, or come from sweeps that have not converged; a strong grab overcomes both. So a grab does not ask for motions that
//! contacts cannot resist: before it pulls, its wanted velocity is projected onto those that lead its body no farther into a wall than
//! [`PRESSED`]. At this depth, the body presses as hard as contacts resist there.

use super::by_body::ByBody;
use super::lanes::State;
use super::{Body, PatchProblem, PointConstraint};
use crate::Both;
use glam::{Vec3, Vec4};
use std::cell::Cell;

/// Depth to which a grab presses its body into a wall whose contacts are springs, m. With those of Soft Step it presses a cube of 1 m with
/// 50 to 550 times its weight: more with time, because springs take over their load at rest.
const PRESSED: f32 = 1e-3;

/// Share of that distance that a grab wants to move in a substep. Contacts respond in some 20 substeps; faster, and the body would swing.
const SHARE: f32 = 0.05;

/// Distance that a grab wants to move in one step against rigid contacts, m. Every sweep adds the impulse of that speed; with conjugate
/// gradients about a quarter of the distance remains as overlap.
const PRESSED_RIGIDLY: f32 = 2e-3;

/// A body leans against another if the contact between them faces the same way: smallest cosine between both normals.
const SAME_WAY: f32 = 0.5;

/// Upper bound of visits to all walls of a body; they end when none has changed the velocity by more than [`FOUND`], m/s.
const VISITS: usize = 16;
const FOUND: f32 = 1e-5;

/// A point of contact between a held body and a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    other: u32,
    /// Points out of the other body.
    normal: Vec3,
    /// From the centres of mass of the held body and of the other, m.
    arms: [Vec3; 2],
    /// Separation when detected, m.
    separation: f32,
    /// The smallest velocity along the normal that the contact allows, relative to the other body, m/s.
    least: f32,
    /// Inverse effective mass of the held body, 1/kg.
    response: f32,
    /// Impulse of the projection, N·s.
    impulse: f32,
}

impl Wall {
    /// Updates the allowed velocity in a substep of `h` s, from the motions of bodies since detection. Contacts correct no faster than
    /// `fastest`, m/s.
    pub fn aim(&mut self, body: u32, motions: &[Cell<State>], h: f32, fastest: f32) {
        let [a, b] = [(body, self.arms[0]), (self.other, self.arms[1])].both(|(body, arm)| {
            let [moved, turned] = motions[body as usize].get().map(Vec4::truncate);
            moved + turned.cross(arm)
        });
        let separation = self.separation + self.normal.dot(a - b);
        let way = separation.max(0.0) + SHARE * (separation.min(0.0) + PRESSED);
        self.least = (-way / h).min(fastest);
    }
}

/// Changes the wanted linear and angular velocity (m/s, rad/s) as little as possible so that the body does not go through walls. Returns
/// whether it has changed them. The grab pulls with the impulse `pull`.
pub(super) fn project(
    walls: &mut [Wall],
    wanted: &mut [Vec3; 2],
    pull: Vec3,
    answer: impl Fn(Vec3, Vec3) -> [Vec3; 2],
    other: impl Fn(u32) -> [Vec3; 2],
) -> bool {
    let mut changed = false;
    for visit in 0..VISITS {
        let mut most = 0f32;
        for wall in &mut *walls {
            if visit == 0 {
                wall.impulse = 0.0;
            }
            let [linear, angular] = other(wall.other);
            // The wall pushes the body out only if the grab presses the body in.
            let least = match wall.normal.dot(pull) < 0.0 {
                true => wall.least,
                false => wall.least.min(0.0),
            };
            let theirs = linear + angular.cross(wall.arms[1]);
            let own = wanted[0] + wanted[1].cross(wall.arms[0]);
            let lack = least - wall.normal.dot(own - theirs);
            let found = (wall.impulse + lack / wall.response).max(0.0);
            let given = found - wall.impulse;
            if given == 0.0 {
                continue;
            }
            changed = true;
            wall.impulse = found;
            most = most.max(given.abs() * wall.response);
            let [linear, angular] = answer(given * wall.normal, wall.arms[0]);
            wanted[0] += linear;
            wanted[1] += angular;
        }
        if most < FOUND {
            break;
        }
    }
    changed
}

/// The contacts of each body, for contacts between these pairs.
pub(super) fn by_body(bodies: usize, pairs: impl Iterator<Item = [u32; 2]> + Clone) -> ByBody<u32> {
    let ends = (0..).zip(pairs);
    let ends = ends.flat_map(|(contact, bodies)| bodies.both(|body| (body, contact)));
    let mut by_body = ByBody::default();
    by_body.fill(bodies, ends);
    by_body
}

/// Finds the walls of held bodies. `contact` returns bodies A and B of a contact, and the normal from B to A.
pub(super) struct Walls<'a, C> {
    of_bodies: &'a ByBody<u32>,
    bodies: &'a [Body],
    contact: C,
}

impl<'a, C: Fn(usize) -> ([u32; 2], Vec3)> Walls<'a, C> {
    pub fn new(of_bodies: &'a ByBody<u32>, bodies: &'a [Body], contact: C) -> Self {
        Self {
            of_bodies,
            bodies,
            contact,
        }
    }

    /// The walls of a held body, whose contacts are those of patches.
    pub fn among_patches(&self, body: u32, problem: &PatchProblem) -> Vec<Wall> {
        let mut walls = Vec::new();
        for (contact, other, normal) in self.found(body) {
            let patch = &problem.patches[contact];
            for point in &problem.points[patch.range()] {
                let arms = self.arms(contact, body, patch.arms.both(|arm| arm + point.offset));
                walls.push(Wall {
                    separation: point.separation,
                    ..wall(&self.bodies[body as usize], other, normal, arms)
                });
            }
        }
        walls
    }

    /// The walls of a held body, whose contacts are points, in a step of `h` s.
    pub fn among_points(&self, body: u32, constraints: &[PointConstraint], h: f32) -> Vec<Wall> {
        let points = self.found(body).map(|(contact, other, normal)| {
            let point = &constraints[contact];
            let arms = self.arms(contact, body, point.arms);
            Wall {
                least: point.target.x - PRESSED_RIGIDLY / h,
                ..wall(&self.bodies[body as usize], other, normal, arms)
            }
        });
        points.collect()
    }

    /// The arms of a contact, that of the body first.
    fn arms(&self, contact: usize, body: u32, [a, b]: [Vec3; 2]) -> [Vec3; 2] {
        match (self.contact)(contact).0[0] == body {
            true => [a, b],
            false => [b, a],
        }
    }

    /// The contacts of a body, each with the other body and the normal out of it.
    fn contacts_of(&self, body: u32) -> impl Iterator<Item = (usize, u32, Vec3)> {
        self.of_bodies.of(body).iter().map(move |&contact| {
            let (bodies, normal) = (self.contact)(contact as usize);
            match bodies[0] == body {
                true => (contact as usize, bodies[1], normal),
                false => (contact as usize, bodies[0], -normal),
            }
        })
    }

    /// The contacts of a body with walls.
    fn found(&self, body: u32) -> impl Iterator<Item = (usize, u32, Vec3)> {
        self.contacts_of(body)
            .filter(move |&(_, other, normal)| self.stands(other, normal, body))
    }

    fn moves(&self, body: u32) -> bool {
        self.bodies[body as usize].inverse_mass > 0.0
    }

    /// Whether a body is fixed, or leans in a direction against one that is. `from` is the body that presses on it.
    fn stands(&self, body: u32, direction: Vec3, from: u32) -> bool {
        if !self.moves(body) {
            return true;
        }
        let mut seen = vec![false; self.bodies.len()];
        let mut open = vec![body];
        (seen[from as usize], seen[body as usize]) = (true, true);
        while let Some(body) = open.pop() {
            for (_, other, normal) in self.contacts_of(body) {
                if normal.dot(direction) < SAME_WAY {
                    continue;
                }
                if !self.moves(other) {
                    return true;
                }
                if !std::mem::replace(&mut seen[other as usize], true) {
                    open.push(other);
                }
            }
        }
        false
    }
}

fn wall(body: &Body, other: u32, normal: Vec3, arms: [Vec3; 2]) -> Wall {
    Wall {
        other,
        normal,
        arms,
        separation: 0.0,
        least: f32::NEG_INFINITY,
        response: body.response(normal, arms[0]),
        impulse: 0.0,
    }
}
