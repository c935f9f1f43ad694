//! A recording on a time line: it plays, and goes to any step, forwards and backwards.

use crate::BuilderSystems;
use crate::clock::Clock;
use crate::look::{Finish, Own};
use crate::pieces::{Piece, Shape};
use crate::tools::refuse;
use bevy::prelude::*;
use drystone::prelude::*;
use drystone::recording::{Divergence, Recording, RecordingError, Replay};
use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

/// Shows a recording instead of a scene. The world is that of the builder, so all overlays show what they show of a scene.
pub struct ReplayPlugin(&'static Recording);

impl ReplayPlugin {
    /// For one recording, which is kept until the program ends.
    pub fn new(recording: Recording) -> Self {
        Self(Box::leak(Box::new(recording)))
    }
}

impl Plugin for ReplayPlugin {
    fn build(&self, app: &mut App) {
        // Steps are taken by the replay, and by nothing else, in the first frame too.
        let mut time = app.world_mut().get_resource_or_init::<Time<Virtual>>();
        time.pause();
        app.insert_resource(Timeline::new(self.0))
            .insert_resource(Clock {
                paused: true,
                ..default()
            })
            .configure_sets(
                Update,
                BuilderSystems::Act.run_if(not(resource_exists::<Timeline>)),
            )
            .add_systems(PostStartup, start)
            .add_systems(
                Update,
                (
                    (
                        keys.run_if(resource_exists::<ButtonInput<KeyCode>>),
                        advance,
                    )
                        .chain()
                        .after(BuilderSystems::Point)
                        .before(BuilderSystems::Ask),
                    recognize
                        .after(BuilderSystems::Ask)
                        .before(BuilderSystems::Show),
                ),
            );
    }
}

/// The replay, and where it goes.
#[derive(Resource)]
pub struct Timeline {
    recording: &'static Recording,
    /// `None` before the world is there.
    replay: Option<Replay<'static>>,
    /// The steps before which something was changed from outside.
    changes: Vec<usize>,
    /// Whether it plays.
    pub playing: bool,
    /// 1 is as fast as life.
    pub speed: f32,
    /// The number of steps after which the state is to be shown.
    wanted: Option<usize>,
    /// The largest number of steps that was shown.
    farthest: usize,
    /// Time for which no step has been taken yet, s.
    left: f32,
}

/// Snapshots that are kept of a long recording.
const KEPT: usize = 64;

/// Steps between two of a short one.
const FEWEST: usize = 30;

/// Time in a frame to get to the step that is wanted. The window stays alive meanwhile.
const BUDGET: Duration = Duration::from_millis(30);

/// Time that one frame makes up for, at most, s.
const MOST: f32 = 0.1;

impl Timeline {
    fn new(recording: &'static Recording) -> Self {
        Self {
            recording,
            replay: None,
            changes: recording.changes().collect(),
            playing: true,
            speed: 1.0,
            wanted: None,
            farthest: 0,
            left: 0.0,
        }
    }

    /// Number of steps of the recording.
    pub fn len(&self) -> usize {
        self.recording.steps()
    }

    /// Whether there is no step.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The steps before which something was changed from outside.
    pub fn changes(&self) -> &[usize] {
        &self.changes
    }

    /// Whether the end of the recording is missing, because the game ended in the middle.
    pub fn is_cut(&self) -> bool {
        !self.recording.is_whole()
    }

    /// Number of steps after which the state is shown.
    pub fn shown(&self) -> usize {
        self.replay.as_ref().map_or(0, Replay::steps)
    }

    /// The number of steps after which the state is shown, or will be soon.
    pub fn target(&self) -> usize {
        self.wanted.unwrap_or(self.shown())
    }

    /// The first body that differs from the recording.
    pub fn divergence(&self) -> Option<&Divergence> {
        self.replay.as_ref()?.divergence()
    }

    /// The length of the next step, or of the last one at the end, s.
    fn dt(&self) -> f32 {
        let last = self.len().saturating_sub(1);
        let length = self.recording.length_of(self.shown().min(last));
        length.unwrap_or_default()
    }

    /// Shows the state after so many steps.
    pub fn go_to(&mut self, step: usize) {
        self.wanted = Some(step.min(self.len()));
        self.left = 0.0;
    }

    /// Goes so many steps forwards, or backwards, and stays there.
    pub fn go_by(&mut self, steps: isize) {
        self.playing = false;
        self.go_to(self.target().saturating_add_signed(steps));
    }

    /// Plays from here, or from the start if this is the end; or stops.
    pub fn toggle(&mut self) {
        self.playing = !self.playing;
        if self.playing && self.target() == self.len() {
            self.go_to(0);
        }
    }

    fn advance(&mut self, world: &mut World, elapsed: f32) -> Result<(), RecordingError> {
        let dt = self.dt();
        let end = self.len();
        let Some(replay) = &mut self.replay else {
            return Ok(());
        };
        if let Some(wanted) = self.wanted {
            if wanted <= self.farthest {
                // A snapshot is near.
                replay.seek(world, wanted)?;
            } else {
                let start = Instant::now();
                if replay.steps() < self.farthest {
                    replay.seek(world, self.farthest)?;
                }
                while replay.steps() < wanted && start.elapsed() < BUDGET {
                    replay.step(world)?;
                }
            }
            self.wanted = Some(wanted).filter(|_| replay.steps() != wanted);
        } else if self.playing {
            self.left += (self.speed * elapsed).min(MOST);
            while self.left >= dt && replay.steps() < end {
                self.left -= dt;
                replay.step(world)?;
            }
            self.playing = replay.steps() < end;
        }
        self.farthest = self.farthest.max(replay.steps());
        Ok(())
    }
}

fn start(world: &mut World) {
    let recording = world.resource::<Timeline>().recording;
    let every = FEWEST.max(recording.steps() / KEPT);
    let every = NonZeroUsize::new(every).unwrap_or(NonZeroUsize::MIN);
    match Replay::start(recording, world) {
        Ok(replay) => {
            world.resource_mut::<Timeline>().replay = Some(replay.with_kept_every(every));
        }
        Err(error) => refuse(world, error.to_string()),
    }
}

fn advance(world: &mut World) {
    let elapsed = world.resource::<Time<Real>>().delta_secs();
    let done = world.resource_scope(|world, mut timeline: Mut<Timeline>| {
        timeline.advance(world, elapsed).inspect_err(|_| {
            timeline.playing = false;
            timeline.wanted = None;
        })
    });
    if let Err(error) = done {
        refuse(world, error.to_string());
    }
}

/// The keys of the time line, and what they do.
pub const KEYS: &str = "Space: play or stop · left, right: a step · Home, End";

fn keys(keys: Res<ButtonInput<KeyCode>>, mut timeline: ResMut<Timeline>) {
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::Space => timeline.toggle(),
            KeyCode::ArrowLeft => timeline.go_by(-1),
            KeyCode::ArrowRight => timeline.go_by(1),
            KeyCode::Home => timeline.go_to(0),
            KeyCode::End => timeline.go_to(usize::MAX),
            _ => (),
        }
    }
}

/// What the look of a body depends on.
type Shown = (
    Entity,
    &'static Collider,
    Option<&'static RigidBody>,
    Option<&'static Density>,
    Option<&'static Piece>,
);

/// Makes pieces of the bodies of the recording, so that they are drawn. Shapes that the builder does not have are not.
fn recognize(mut commands: Commands, bodies: Query<Shown, (Changed<Collider>, With<Transform>)>) {
    for (entity, collider, kind, density, before) in &bodies {
        let Some(shape) = Shape::of(collider) else {
            continue;
        };
        if before.is_none_or(|piece| piece.shape != shape) {
            let density = density.map_or(Density::DEFAULT, |density| density.0);
            let fixed = kind == Some(&RigidBody::Static);
            let finish = Finish::of_density(density);
            let piece = Piece {
                shape,
                finish,
                fixed,
            };
            commands.entity(entity).insert(piece).remove::<Own>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::time::{TimePlugin, TimeUpdateStrategy};
    use drystone::recording::{Recorder, RecorderSettings};

    const DT: f32 = 1.0 / 60.0;
    const STEPS: usize = 120;

    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((
            TimePlugin,
            DrystonePlugins::default(),
            HandPlugin,
            CollapsePlugin,
        ));
        app
    }

    fn piece(shape: Shape, finish: Finish, at: [f32; 3]) -> impl Bundle {
        let pose = Pose {
            position: at.into(),
            ..default()
        };
        Piece::new(shape, finish).bundle(pose).unwrap()
    }

    /// Positions in the order of spawning.
    fn seen(world: &mut World) -> Vec<Vec3> {
        let mut bodies = world.query_filtered::<(&SpawnOrder, &Pose), With<RigidBody>>();
        let mut bodies: Vec<_> = bodies.iter(world).collect();
        bodies.sort_by_key(|(order, _)| **order);
        bodies.into_iter().map(|(_, pose)| pose.position).collect()
    }

    /// A stack that is hit by a ball, and what is seen after so many steps.
    fn recorded() -> (Recording, Vec<Vec<Vec3>>) {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        for i in 0..4 {
            let at = [0.0, 0.25 + 0.5 * i as f32, 0.0];
            world.spawn(piece(
                Shape::Box(Vec3::new(1.0, 0.5, 0.5)),
                Finish::Brick,
                at,
            ));
        }
        Recorder::start(world, RecorderSettings::default()).unwrap();
        let mut all = vec![seen(world)];
        for step in 0..STEPS {
            if step == 40 {
                let ball = piece(Shape::Ball(0.35), Finish::Iron, [0.0, 1.5, 3.0]);
                world.spawn((ball, Velocity::linear(Vec3::NEG_Z * 12.0)));
            }
            drystone::step(world, DT).unwrap();
            all.push(seen(world));
        }
        let bytes = Recorder::stop(world).unwrap();
        (Recording::from_bytes(&bytes).unwrap(), all)
    }

    fn until_it_is_there(app: &mut App) {
        let start = Instant::now();
        loop {
            app.update();
            let timeline = app.world().resource::<Timeline>();
            if timeline.shown() == timeline.target() && !timeline.playing {
                return;
            }
            assert!(start.elapsed() < Duration::from_secs(60));
        }
    }

    #[test]
    fn a_recording_plays_and_goes_to_any_step() {
        let (recording, all) = recorded();
        let mut app = app();
        app.add_plugins(ReplayPlugin::new(recording))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(
                DT,
            )));
        until_it_is_there(&mut app);
        let timeline = app.world().resource::<Timeline>();
        assert_eq!(timeline.shown(), STEPS);
        assert_eq!(timeline.changes(), [40]);
        assert_eq!(timeline.divergence(), None);
        let mut pieces = app.world_mut().query::<&Piece>();
        let finishes = pieces.iter(app.world()).map(|piece| piece.finish);
        let iron = finishes.filter(|finish| *finish == Finish::Iron).count();
        assert_eq!((pieces.iter(app.world()).count(), iron), (5, 1));
        for step in [100, 20, 45, 0, STEPS, 33] {
            app.world_mut().resource_mut::<Timeline>().go_to(step);
            until_it_is_there(&mut app);
            assert_eq!(seen(app.world_mut()), all[step], "{step}");
        }
        for by in [1, 1, -2, -1] {
            app.world_mut().resource_mut::<Timeline>().go_by(by);
            until_it_is_there(&mut app);
        }
        assert_eq!(seen(app.world_mut()), all[32]);
        let mut pieces = app.world_mut().query::<&Piece>();
        assert_eq!(pieces.iter(app.world()).count(), 4, "no ball is there yet");
    }

    /// At the end, it plays from the start again.
    #[test]
    fn it_plays_again() {
        let mut app = app();
        app.add_plugins(ReplayPlugin::new(recorded().0))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(
                DT,
            )));
        until_it_is_there(&mut app);
        app.world_mut().resource_mut::<Timeline>().toggle();
        app.update();
        assert_eq!(app.world().resource::<Timeline>().shown(), 0);
        until_it_is_there(&mut app);
        assert_eq!(app.world().resource::<Timeline>().shown(), STEPS);
    }
}
