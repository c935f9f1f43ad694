//! The cases on which methods are compared, with the numbers of iterations and repetitions.

use crate::methods::{Family, Method};
use drystone::settings::Preset;
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::Scene;

/// A scene at a time step.
#[derive(Clone, Copy, PartialEq)]
pub struct Case {
    pub scene: Scene,
    /// s
    pub dt: f32,
    /// How long it must stand.
    pub seconds: f32,
}

/// How thorough the study is.
#[derive(Clone, Copy)]
pub struct Scope {
    pub quick: bool,
    /// Only the methods of part 3.
    pub baselines: bool,
}

const SCENES: [Scene; 6] = [
    Scene::Wall(20, 15),
    Scene::Wall(40, 25),
    Scene::Stack(20),
    Scene::Pyramid(20),
    Scene::Arch(15),
    Scene::MassRatio(100.0, 5),
];

/// Time steps, and how long is simulated, s; less when quick.
pub const TIMES: [(f32, f32, f32); 2] = [(1.0 / 60.0, 10.0, 2.0), (0.1, 60.0, 10.0)];

/// Iterations of the paper's solvers. Two to six cost as much as the default.
const BUDGETS: [usize; 8] = [2, 4, 6, 12, 24, 48, 75, 150];
const SOFT_BUDGETS: [usize; 4] = [6, 12, 24, 48];
const AVBD_BUDGETS: [usize; 6] = [2, 4, 6, 20, 40, 80];

impl Case {
    /// The scene with the settings of a preset except the time step and sleeping, and with the prototype's noise and gaps.
    pub fn experiment(&self, preset: Preset) -> Experiment {
        let mut experiment = Experiment {
            options: Experiment::new(self.scene, Preset::Paper).options,
            dt: self.dt,
            ..Experiment::new(self.scene, preset)
        };
        experiment.sleeping.enabled = false;
        experiment
    }

    /// As file names and headings have it.
    pub fn name(&self) -> String {
        let scene = self.scene.to_string().replace(':', "-");
        format!("{scene}-{}", time_step(self.dt).replace(' ', ""))
    }

    fn bodies(&self) -> u32 {
        match self.scene {
            Scene::Wall(w, h) => w * h + h / 2,
            Scene::Pyramid(n) => n * (n + 1) / 2,
            Scene::Stack(n) | Scene::Arch(n) => n,
            _ => 6,
        }
    }
}

/// In words.
pub fn time_step(dt: f32) -> String {
    if dt < 0.05 {
        format!("{:.0} Hz", 1.0 / dt)
    } else {
        format!("dt {dt}")
    }
}

impl Scope {
    pub fn cases(self) -> Vec<Case> {
        let is_long = |scene: &Scene| matches!(scene, Scene::Wall(40, _) | Scene::Pyramid(_));
        let scenes = SCENES
            .into_iter()
            .filter(|scene| !self.quick || !is_long(scene));
        let at_times = |scene| {
            TIMES.map(|(dt, full, quick)| Case {
                scene,
                dt,
                seconds: if self.quick { quick } else { full },
            })
        };
        scenes.flat_map(at_times).collect()
    }

    /// Expected time of a run, s. It depends on the case alone, so that the load of the machine does not decide which cases are run.
    fn expected(self, case: &Case, method: &Method, iterations: usize) -> f32 {
        let steps = case.seconds / case.dt;
        let iterations = iterations as f32;
        let per_body = match method.family {
            Family::SoftStep => 1.0 + 0.05 * iterations,
            Family::Paper | Family::Avbd | Family::Apgd => 2.0 + iterations,
        };
        1e-6 * steps * case.bodies() as f32 * per_body
    }

    /// Iterations of a method that are worth their time in a case. Those that it is meant for may take longer.
    pub fn budgets(self, case: &Case, method: &Method) -> Vec<usize> {
        let mut all = match method.family {
            Family::SoftStep => SOFT_BUDGETS.to_vec(),
            Family::Avbd => AVBD_BUDGETS.to_vec(),
            Family::Paper | Family::Apgd => BUDGETS.to_vec(),
        };
        all.push(method.own_iterations(case));
        all.sort_unstable();
        all.dedup();
        let affordable = |&n: &usize| {
            let longest = match self.quick {
                true => 0.17,
                false if n == method.own_iterations(case) => 15.0,
                false => 2.5,
            };
            self.expected(case, method, n) < longest
        };
        all.into_iter().filter(affordable).collect()
    }

    /// One seed where a run takes long.
    pub fn seeds(self, case: &Case, method: &Method, iterations: usize) -> u64 {
        if self.expected(case, method, iterations) < 0.42 {
            self.all_seeds()
        } else {
            1
        }
    }

    /// The number of seeds of the small cases.
    pub fn all_seeds(self) -> u64 {
        if self.quick { 1 } else { 3 }
    }
}
