//! Bodies that dry contacts hold. If such a body moves on slowly, the solver lets it creep: nothing drives it.

use crate::body::BodyState;
use crate::graph::{ConstraintGraph, Islands, edges::EdgeKind, forces::Forces};
use crate::joint_types::JointEdge;
use crate::pair::MovingSurfaces;
use crate::settings::Gravity;
use crate::solver::JointAxis;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

/// Share of its weight with which contacts with friction press on a body that they hold.
const PRESSING_SHARE: f32 = 0.5;

/// The contacts and joints that hold bodies, and the forces that drive them.
#[derive(SystemParam, Debug)]
pub struct Holding<'w, 's> {
    graph: Res<'w, ConstraintGraph>,
    gravity: Res<'w, Gravity>,
    surfaces: Res<'w, MovingSurfaces>,
    forces: Forces<'w, 's>,
    joints: Query<'w, 's, &'static JointEdge>,
}

impl Holding<'_, '_> {
    /// Returns true if dry contacts hold a body on which nothing else acts that could move it steadily.
    pub(in crate::graph) fn holds(&self, slot: u32, body: &BodyState) -> bool {
        let limits = [
            body.properties.max_linear_speed.0,
            body.properties.max_angular_speed.0,
        ];
        if body.is_curved() || body.is_pushed() || limits != [f32::INFINITY; 2] {
            return false;
        }
        let weight = body.mass.mass() * (body.gravity_scale * self.gravity.0).length();
        let links = self.graph.links_of(slot);
        let links = links.filter(|link| link.kind == EdgeKind::Contact);
        let pressing = links.filter_map(|link| {
            let (pair, _, impulses) = self.forces.contact(&link)?;
            let points = impulses.points.iter().map(|point| point.normal_force);
            (pair.friction > 0.0).then(|| points.sum::<f32>())
        });
        weight > 0.0 && pressing.sum::<f32>() > PRESSING_SHARE * weight
    }

    /// Returns true if a surface that moves, or a joint that turns or slides, may drive the bodies of an island.
    pub(in crate::graph) fn is_driven(&self, islands: &Islands, island: usize) -> bool {
        if self.surfaces.is_empty() && !self.graph.has_joints() {
            return false;
        }
        let members = islands.members_of_id(islands.numbered()[island]);
        let mut links = members.iter().flat_map(|&slot| self.graph.links_of(slot));
        let moves = |joint: Entity| {
            let joint = self.joints.get(joint).ok();
            joint.is_some_and(|joint| !joint.definition.axes.iter().all(JointAxis::is_locked))
        };
        links.any(|link| match link.kind {
            EdgeKind::Contact => self.surfaces.get(link.edge).is_some(),
            EdgeKind::Joint => moves(link.pair),
        })
    }
}
