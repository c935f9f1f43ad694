//! Part 2: the open questions of the paper, answered with figures.

use crate::cases::{Case, Scope, time_step};
use crate::runs::Finding;
use crate::tables::{Table, mm};
use drystone::settings::{AnchorRule, Classifier, FrictionStabilization, Preset};
use drystone_lab::scenes::Scene;
use indicatif::ProgressBar;

/// A rule for each row, a scene for each column.
pub struct Question {
    title: &'static str,
    note: &'static str,
    rules: &'static [(&'static str, Rule)],
    columns: Vec<Column>,
}

type Rule = fn(&mut FrictionStabilization);

#[derive(Clone)]
struct Column {
    case: Case,
    /// The preset with the solver: NNCG 75 or Soft Step.
    preset: Preset,
    figure: Figure,
}

/// The quantity shown, with its name.
type Figure = (&'static str, fn(&Finding) -> String);

const CLASSIFIERS: &[(&str, Rule)] = &[
    ("per point", |f| f.classifier = Classifier::PerPoint),
    ("any point", |f| f.classifier = Classifier::Any),
    ("all points", |f| f.classifier = Classifier::All),
    ("sum", |f| f.classifier = Classifier::Sum),
    ("sum with hysteresis", |f| {
        f.classifier = Classifier::Hysteresis
    }),
];

const ANCHORS: &[(&str, Rule)] = &[
    ("none", |f| f.enabled = false),
    ("trackless", |f| f.anchors = AnchorRule::Trackless),
    ("literal", |f| f.anchors = AnchorRule::Literal),
    ("persistent", |f| f.anchors = AnchorRule::Persistent),
    ("pair-pose", |f| f.anchors = AnchorRule::PairPose),
];

const STATES: &[(&str, Rule)] = &[CLASSIFIERS[0], CLASSIFIERS[3]];

const DRIFT: Figure = ("drift", |f| f.fate().unwrap_or_else(|| mm(f.drift)));
const JITTER: Figure = ("drift, rms speed in mm/s", |f| {
    let figures = || format!("{}, {:.2}", mm(f.drift), 1e3 * f.rms_speed);
    f.fate().unwrap_or_else(figures)
});
const WAY: Figure = ("way, m", |f| format!("{:.3}", f.drift));
const SPEED: Figure = ("speed, m/s", |f| format!("{:.4}", f.speed));

/// Simulated time for structures that should stand, and for moving bodies, s.
const LONG: f32 = 60.0;
const MIDDLE: f32 = 20.0;
const SHORT: f32 = 5.0;

pub fn questions() -> Vec<Question> {
    let slab = Scene::Incline(26.4);
    let paper = |scene| column(Preset::Paper, scene, LONG, DRIFT);
    let nncg = || {
        [Scene::Wall(6, 6), Scene::Stack(5), Scene::Stack(10), slab]
            .map(paper)
            .into()
    };
    let soft_step = || {
        let at_60_hz = |scene| column(Preset::Default, scene, MIDDLE, DRIFT);
        let large = |scene| Column {
            case: Case {
                scene,
                dt: 0.1,
                seconds: LONG,
            },
            ..at_60_hz(scene)
        };
        let scenes = [Scene::Wall(10, 10), Scene::Stack(20), slab];
        [scenes.map(at_60_hz), scenes.map(large)].concat()
    };
    let moving = [Preset::Paper, Preset::Default].map(|preset| {
        [
            column(preset, Scene::Rolling, SHORT, SPEED),
            column(preset, Scene::Sliding, SHORT, WAY),
        ]
    });
    let states = [Scene::Wall(6, 6), Scene::Stack(10)]
        .map(|scene| column(Preset::Paper, scene, LONG, JITTER));
    let slopes = [20.0, 24.0, 26.0, 26.4].map(|degrees| paper(Scene::Incline(degrees)));
    vec![
        Question {
            title: "Which classifier? NNCG",
            note: "Drift in mm after 60 s: NNCG 75, persistent anchors, Δt 0.1. The slab's is its way down a slope just below the \
                critical 26.57°.",
            rules: CLASSIFIERS,
            columns: nncg(),
        },
        Question {
            title: "Which classifier? Soft Step",
            note: "Drift in mm after 20 s at 60 Hz and after 60 s at Δt 0.1, pair-pose anchors.",
            rules: CLASSIFIERS,
            columns: soft_step(),
        },
        Question {
            title: "Can tracking be done without? NNCG",
            note: "As before, classified on sums. Pair-pose and trackless need no contact points matched from step to step.",
            rules: ANCHORS,
            columns: nncg(),
        },
        Question {
            title: "Can tracking be done without? Soft Step",
            note: "As before, classified on sums.",
            rules: ANCHORS,
            columns: soft_step(),
        },
        Question {
            title: "Is rolling told from sliding?",
            note: "A sphere that rolls at 1 m/s: its speed after 5 s. A slab that slides at 3 m/s: its way; v²/(2 μ g) is 0.917 m, in \
                steps of 0.1 s v Δt/2 less: 0.767 m. NNCG 75, Soft Step.",
            rules: ANCHORS,
            columns: moving.into_iter().flatten().collect(),
        },
        Question {
            title: "One state per manifold?",
            note: "Each point for itself against the sums over its manifold: NNCG 75, persistent anchors, Δt 0.1, 60 s. Drift in mm.",
            rules: STATES,
            columns: states.into_iter().chain(slopes).collect(),
        },
    ]
}

fn column(preset: Preset, scene: Scene, seconds: f32, figure: Figure) -> Column {
    let case = Case {
        scene,
        dt: preset.dt(),
        seconds,
    };
    Column {
        case,
        preset,
        figure,
    }
}

impl Column {
    fn heading(&self) -> String {
        let Case { scene, dt, .. } = self.case;
        format!("{scene}, {}: {}", time_step(dt), self.figure.0)
    }

    fn cell(&self, rule: Rule, scope: Scope) -> String {
        let mut experiment = self.case.experiment(self.preset);
        rule(&mut experiment.stabilization.friction);
        // Slabs and spheres are placed without noise.
        let seeds = match self.case.scene {
            Scene::Wall(..) | Scene::Stack(_) => scope.all_seeds(),
            _ => 1,
        };
        (self.figure.1)(&Finding::of(&experiment, self.case.seconds, seeds))
    }
}

impl Question {
    /// How many cells the answer has.
    pub fn cells(&self) -> usize {
        self.rules.len() * self.columns.len()
    }

    pub fn answer(&self, scope: Scope, bar: &ProgressBar) -> Table {
        bar.set_message(self.title);
        let row = |&(name, rule): &(&str, Rule)| {
            let cell = |column: &Column| {
                bar.inc(1);
                column.cell(rule, scope)
            };
            let cells = self.columns.iter().map(cell);
            [name.to_owned()].into_iter().chain(cells).collect()
        };
        let headings = self.columns.iter().map(Column::heading);
        Table {
            title: self.title.to_owned(),
            note: self.note.to_owned(),
            columns: ["rule".to_owned()].into_iter().chain(headings).collect(),
            rows: self.rules.iter().map(row).collect(),
        }
    }
}
