//! Storing the results of a solve in the components of bodies, pairs and grabs, which are found by their entities.

use super::{Acting, Solve};
use crate::body::{ActiveBodies, GrabForce, Motion, SpawnOrder, Velocity, limits};
use crate::joint::JointBroke;
use crate::joint_types::JointForces;
use crate::mortar::MortarBroke;
use crate::pair::{ContactImpulses, Impulse, PatchImpulse, PointFriction};
use crate::solver::{Both, GrabConstraint, groups::Groups, sort};
use crate::warm_start::{Grabs, Island, LARGE_ISLAND_FACTOR, Pairs, ProblemSet, Rows, Stored};
use bevy_ecs::change_detection::DetectChangesMut;
use glam::Vec3;

impl Solve<'_> {
    pub(super) fn store(
        &self,
        problems: &mut ProblemSet,
        pairs: &mut Pairs,
        bodies: &mut ActiveBodies,
        acting: &mut Acting,
    ) {
        self.store_impulses(problems, pairs);
        self.store_bodies(problems, bodies);
        store_grabs(problems, acting.grabs);
        self.store_joints(problems, acting);
        let diverged = problems.islands.iter_mut();
        for island in diverged.filter(|island| island.diverged) {
            island.rows.clear();
        }
    }

    fn store_impulses(&self, problems: &mut ProblemSet, pairs: &mut Pairs) {
        let dt = self.context.time.dt;
        let ProblemSet { order, islands, .. } = problems;
        let points: usize = islands.iter().map(Island::points).sum();
        let threads = &*self.context.threads;
        let threads = threads
            .runs_in_parallel(points / LARGE_ISLAND_FACTOR)
            .then_some(threads);
        order.store_each(pairs, self.graph, threads, |stored: Stored| {
            let Stored {
                island,
                contact,
                renewed,
                manifold,
                impulses,
            } = stored;
            let island = &islands[island as usize];
            let contact = contact as usize;
            impulses.fit(manifold);
            if island.diverged || renewed || !island.rows.store(contact, manifold, impulses, dt) {
                impulses.forget();
            }
        });
    }

    /// Stores the velocities and motions of awake bodies.
    fn store_bodies(&self, problems: &ProblemSet, bodies: &mut ActiveBodies) {
        let fall = self.context.gravity.0.length() * self.context.time.dt;
        for of in bodies {
            let (entity, index) = (of.entity, of.index);
            let (mut velocity, mut motion) = (of.velocity, of.motion);
            let Some(body) = self.table.get(index.0).filter(|body| body.entity == entity) else {
                continue;
            };
            // Sleeping bodies are not in a problem.
            let Some(&local) = problems.order.local.get(index.0 as usize) else {
                continue;
            };
            let island = self.islands.of(index.0);
            let island = island.and_then(|island| problems.islands.get(island));
            let solved =
                island.and_then(|island| Some((island, island.bodies.get(local as usize)?)));
            let Some((island, solved)) = solved else {
                continue;
            };
            let mut end = clean([solved.linear, solved.angular]);
            self.context.speeds.cap(&mut end);
            body.properties.restrain(&mut end);
            *velocity.bypass_change_detection() = end;
            *motion.bypass_change_detection() = match solved.motion {
                Some(mean) => {
                    let mut mean = clean(mean);
                    body.properties.restrain(&mut mean);
                    match solved.motion_is_exact {
                        true => Motion::Exact { mean, end },
                        false => Motion::Mean { mean, end },
                    }
                }
                None if matches!(island.rows, Rows::Patches(_)) => {
                    let mut start = body.velocity;
                    body.properties.restrain(&mut start);
                    let gained = end.linear - start.linear;
                    Motion::Flight {
                        gained: gained.clamp_length_max(fall),
                    }
                }
                None => Motion::Steady,
            };
        }
    }

    /// Stores the forces of joints, and finds those that break. A joint that breaks relieves those that it is connected with, so of these
    /// only the one that is loaded most breaks. The others get another step.
    fn store_joints(&self, problems: &ProblemSet, acting: &mut Acting) {
        let mut overloaded: Vec<Overloaded> = Vec::new();
        for gathered in &problems.joints.gathered {
            let Some(island) = problems.islands.get(gathered.island as usize) else {
                continue;
            };
            let Some(solved) = island.joints.get(gathered.index as usize) else {
                continue;
            };
            if let Ok((edge, mut forces, breaks)) = acting.joints.get_mut(gathered.joint)
                && edge.edge == gathered.edge
            {
                let before = *forces;
                forces.set_if_neq(JointForces::of(solved));
                if let Some(found) = solved.broke
                    && !island.diverged
                {
                    let broke = MortarBroke::new(gathered.joint, edge, self.table, found);
                    let broke = broke.map(|broke| (edge.order, broke));
                    acting.broken_mortar.found.extend(broke);
                }
                let used = breaks.and_then(|breaks| breaks.exceeded_share(&before, &forces));
                if let Some(share) = used.filter(|_| !island.diverged) {
                    overloaded.push(Overloaded {
                        island: gathered.island,
                        index: gathered.index,
                        share,
                        order: edge.order,
                        broke: JointBroke::new(gathered.joint, edge, &forces),
                    });
                }
            }
        }
        keep_most_loaded(&mut overloaded, problems);
        let broken = overloaded
            .into_iter()
            .map(|joint| (joint.order, joint.broke));
        acting.broken.found.extend(broken);
    }
}

/// A joint whose strength was exceeded.
#[derive(Clone, Copy)]
struct Overloaded {
    island: u32,
    /// Its index in the island.
    index: u32,
    /// Its load as a share of its strength.
    share: f32,
    order: SpawnOrder,
    broke: JointBroke,
}

/// Keeps one overloaded joint of each group of bodies that joints connect: the one that is loaded most.
fn keep_most_loaded(overloaded: &mut Vec<Overloaded>, problems: &ProblemSet) {
    if overloaded.len() < 2 {
        return;
    }
    sort::by_key(overloaded, |joint| (joint.island, joint.index));
    let mut groups = Groups::default();
    let mut kept: Vec<Overloaded> = Vec::new();
    for of_island in overloaded.chunk_by(|a, b| a.island == b.island) {
        let island = &problems.islands[of_island[0].island as usize];
        let moves = |body: &u32| island.bodies[*body as usize].inverse_mass > 0.0;
        groups.begin(island.bodies.len());
        for joint in &island.joints {
            // A fixed body passes nothing on.
            if joint.bodies.iter().all(moves) {
                groups.link(joint.bodies);
            }
        }
        let first = kept.len();
        let mut of_groups: Vec<u32> = Vec::new();
        for joint in of_island {
            let ends = island.joints[joint.index as usize].bodies;
            let Some(body) = ends.into_iter().find(moves) else {
                continue;
            };
            let group = groups.first_of(body);
            match of_groups.iter().position(|&of| of == group) {
                None => {
                    of_groups.push(group);
                    kept.push(*joint);
                }
                Some(at) if kept[first + at].share < joint.share => kept[first + at] = *joint,
                Some(_) => {}
            }
        }
    }
    *overloaded = kept;
}

/// Stores the forces of grabs.
fn store_grabs(problems: &ProblemSet, grabs: &mut Grabs) {
    for held in &problems.held {
        let mut solved = problems.islands[held.island].grabs.iter();
        if let Some(grab) = solved.find(|grab| grab.body == held.local)
            && let Ok((.., mut kept)) = grabs.get_mut(held.entity)
        {
            let &GrabConstraint { force, torque, .. } = grab;
            kept.set_if_neq(GrabForce { force, torque });
        }
    }
}

/// The computed velocity, with tiny numbers set to zero.
#[inline]
fn clean(velocity: [Vec3; 2]) -> Velocity {
    let [linear, angular] = velocity.both(|v| limits::flush_to_zero(v.extend(0.0)).truncate());
    Velocity { linear, angular }
}

impl ContactImpulses {
    /// Sets all impulses and forces to zero.
    fn forget(&mut self) {
        self.points.fill(Impulse::default());
        self.friction.fill(PointFriction::default());
        self.patches.fill(PatchImpulse::default());
    }
}
