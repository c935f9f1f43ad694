//! Part 2: what the paper leaves open, answered with figures.

use crate::cases::{Case, Scope};
use crate::runs::Finding;
use crate::tables::{Table, mm};
use drystone::scenes::Scene;
use drystone::settings::{AnchorRule, Classifier, FrictionStabilization, Preset};
use indicatif::ProgressBar;

/// A rule for each row, a scene for each column.
pub struct Question {
    title: &'static str,
    note: &'static str,
    rules: &'static [(&'static str, Rule)],
    columns: Vec<Column>,
}

type Rule = fn(&mut FrictionStabilization);

struct Column {
    case: Case,
    /// Whose solver: NNCG 75 or Soft Step.
    preset: Preset,
    figure: Figure,
}

/// What is shown, with its name.
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
const JITTER: Figure = ("rms speed, mm/s", |f| {
    f.fate()
        .unwrap_or_else(|| format!("{:.3}", 1e3 * f.rms_speed))
});
const WAY: Figure = ("way, m", |f| format!("{:.3}", f.drift));
const SPEED: Figure = ("speed, m/s", |f| format!("{:.4}", f.speed));

/// At Δt 0.1 a slab is to hold for as long as a wall; what moves has come to rest or not after 5 s.
const LONG: f32 = 60.0;
const SHORT: f32 = 5.0;

pub fn questions() -> Vec<Question> {
    let slab = Scene::Incline(26.4);
    let paper = |scene| column(Preset::Paper, scene, LONG, DRIFT);
    let soft = |scene| column(Preset::Default, scene, 20.0, DRIFT);
    let structures = || {
        let paper = [Scene::Wall(6, 6), Scene::Stack(5), Scene::Stack(10), slab].map(paper);
        let soft = [Scene::Wall(10, 10), Scene::Stack(20), slab].map(soft);
        paper.into_iter().chain(soft).collect::<Vec<_>>()
    };
    let moving = [Preset::Paper, Preset::Default].map(|preset| {
        [
            column(preset, Scene::Rolling, SHORT, SPEED),
            column(preset, Scene::Sliding, SHORT, WAY),
        ]
    });
    let states = [Scene::Wall(6, 6), Scene::Stack(10)].map(|scene| {
        [
            column(Preset::Paper, scene, LONG, DRIFT),
            column(Preset::Paper, scene, LONG, JITTER),
        ]
    });
    let slopes = [20.0, 24.0, 26.0, 26.4].map(|degrees| paper(Scene::Incline(degrees)));
    vec![
        Question {
            title: "Which classifier?",
            note: "Drift in mm: NNCG 75 with persistent anchors, Δt 0.1, 60 s; Soft Step with its pair-pose anchors, 60 Hz, 20 s. The slab's is its way down \
                a slope just below the critical 26.57°.",
            rules: CLASSIFIERS,
            columns: structures(),
        },
        Question {
            title: "Can tracking be done without?",
            note: "Drift in mm, classified on sums; otherwise as before. Trackless, pair-pose and none know nothing of points.",
            rules: ANCHORS,
            columns: structures(),
        },
        Question {
            title: "Is rolling told from sliding?",
            note: "A sphere that rolls at 1 m/s: its speed after 5 s. A slab that slides at 3 m/s: its way; v²/(2 μ g) is 0.917 m, and the largest way of Δt-long steps \
                half a step longer or shorter. NNCG 75 at Δt 0.1, Soft Step at 60 Hz.",
            rules: ANCHORS,
            columns: moving.into_iter().flatten().collect(),
        },
        Question {
            title: "One state per manifold?",
            note: "Persistent anchors, NNCG 75, Δt 0.1, 60 s: each point for itself against the sums over its manifold. Drift in mm.",
            rules: STATES,
            columns: states.into_iter().flatten().chain(slopes).collect(),
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
        let solver = match self.preset {
            Preset::Paper => "NNCG",
            Preset::Default => "Soft Step",
        };
        format!("{}, {solver}: {}", self.case.scene, self.figure.0)
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
