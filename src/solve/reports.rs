//! Reports of the solves of a step.

use crate::diagnosis::{BodyProblem, FoundProblems, ReportedProblems};
use crate::solver::SolveReport;
use crate::warm_start::{Island, ProblemSet};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The reports of the last step's solves, one for each island that had contacts.
#[derive(Resource, Default, Clone, Debug)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[component(clone_behavior = Ignore)]
pub struct SolveReports(pub Vec<IslandReport>);

/// The report of one island's solve.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
pub struct IslandReport {
    /// Number of its bodies, including copies of static and kinematic ones.
    pub bodies: usize,
    /// Number of its contact points.
    pub contacts: usize,
    /// The report of the solver.
    pub report: SolveReport,
}

/// Writes the reports of a step.
#[derive(SystemParam, Debug)]
pub struct ReportWriter<'w> {
    reports: ResMut<'w, SolveReports>,
    suspects: ResMut<'w, FoundProblems>,
    told: ResMut<'w, ReportedProblems>,
}

impl ReportWriter<'_> {
    /// Reports each solved island. When an island begins to diverge, its first body is reported as a problem.
    pub(super) fn report(&mut self, problems: &ProblemSet) {
        let ProblemSet { islands, order, .. } = problems;
        let touching = islands.iter().filter(|island| island.points() > 0);
        self.reports.0.clear();
        self.reports.0.extend(touching.map(report));
        let wrong = islands.iter().enumerate();
        let wrong = wrong.filter(|(_, island)| island.diverged);
        let wrong = wrong.filter_map(|(number, _)| order.of(number).bodies.first());
        let wrong: Vec<Entity> = wrong.map(|member| member.entity).collect();
        let new = wrong
            .iter()
            .filter(|entity| !self.told.diverged.contains(entity));
        self.suspects
            .0
            .extend(new.map(|&entity| (entity, BodyProblem::Diverged)));
        self.told.diverged = wrong;
    }
}

fn report(island: &Island) -> IslandReport {
    IslandReport {
        bodies: island.bodies.len(),
        contacts: island.points(),
        report: island.report.clone(),
    }
}
