//! Tests of the panel, in an app without a window and without a renderer.

use bevy_app::{App, TaskPoolPlugin};
use bevy_ecs::prelude::*;
use bevy_input::ButtonInput;
use bevy_input::keyboard::KeyCode;
use bevy_transform::components::Transform;
use bevy_ui::widget::Text;
use bevy_ui::{Node, UiRect, Val};
use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin};
use drystone::prelude::*;
use drystone::snapshot::Snapshot;
use std::time::Duration;

/// Three cubes side by side on the ground.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), DrystonePlugins::default()))
        .add_plugins(PhysicsPanelPlugin)
        .init_resource::<ButtonInput<KeyCode>>();
    app.world_mut().resource_mut::<PhysicsPanel>().interval = Duration::ZERO;
    app.finish();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    for i in 0..3 {
        let cube = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0));
        let place = Transform::from_xyz(3.0 * i as f32, 0.5, 0.0);
        world.spawn((cube, place, Name::new(format!("cube {i}"))));
    }
    app
}

fn steps(app: &mut App, count: usize) {
    for _ in 0..count {
        drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
        app.update();
    }
}

/// Presses and releases a key.
fn press(app: &mut App, key: KeyCode) {
    let world = app.world_mut();
    world.resource_mut::<ButtonInput<KeyCode>>().press(key);
    app.update();
    let mut keys = app.world_mut().resource_mut::<ButtonInput<KeyCode>>();
    keys.release(key);
    keys.clear();
}

fn texts(app: &mut App) -> Vec<String> {
    let world = app.world_mut();
    let mut texts = world.query::<&Text>();
    texts.iter(world).map(|text| text.0.clone()).collect()
}

fn shows(app: &mut App, text: &str) -> bool {
    texts(app).iter().any(|shown| shown == text)
}

fn nodes(app: &mut App) -> Vec<(Entity, Node)> {
    let world = app.world_mut();
    let mut nodes = world.query::<(Entity, &Node)>();
    nodes
        .iter(world)
        .map(|(of, node)| (of, node.clone()))
        .collect()
}

#[test]
fn a_key_shows_and_hides_it_and_hidden_it_has_no_entities() {
    let mut app = app();
    steps(&mut app, 3);
    assert!(nodes(&mut app).is_empty(), "it is hidden at first");
    press(&mut app, KeyCode::F3);
    assert!(shows(&mut app, "narrowphase"));
    press(&mut app, KeyCode::F3);
    app.update();
    assert!(nodes(&mut app).is_empty());
    app.world_mut().resource_mut::<PhysicsPanel>().key = None;
    press(&mut app, KeyCode::F3);
    assert!(nodes(&mut app).is_empty());
}

#[test]
fn it_shows_each_stage_with_its_time_and_the_counts() {
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
    steps(&mut app, 5);
    let stages = app.world().resource::<Profile>().systems();
    for (stage, _) in &stages {
        assert!(shows(&mut app, &stage.replace('_', " ")), "{stage}");
    }
    let all = texts(&mut app);
    let place = |stage: &str| all.iter().position(|text| text == stage).unwrap();
    let order = [
        "prepare",
        "broadphase",
        "warm start",
        "solve",
        "integration",
        "sensors",
    ];
    assert!(order.map(place).is_sorted(), "{all:?}");
    let times = all.iter().filter(|text| text.ends_with(" ms")).count();
    assert_eq!(times, stages.len() + 1);
    let step = all.iter().find(|text| text.contains(" of 16.7 ms"));
    let step: f32 = step.unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(step > 0.0);
    assert!(shows(&mut app, "3 awake, 0 asleep"));
    assert!(shows(&mut app, "1 static, 0 kinematic"));
    assert!(shows(&mut app, "3 awake, largest 1"));
    assert!(shows(&mut app, "3 visited of 3"));
    let memory = all.iter().find(|text| text.starts_with("bodies "));
    assert!(!memory.unwrap().contains("bodies 0 KiB"), "{memory:?}");
    steps(&mut app, 120);
    assert!(shows(&mut app, "0 awake, 3 asleep"));
    assert!(shows(&mut app, "none awake"));
}

#[test]
fn it_says_who_woke_whom() {
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
    steps(&mut app, 120);
    let ball = (RigidBody::Dynamic, Collider::ball(0.3), Density(5000.0));
    let place = Transform::from_xyz(3.0, 0.5, 2.0);
    let flies = Velocity::linear(Vec3::NEG_Z * 8.0);
    app.world_mut()
        .spawn((ball, place, flies, Name::new("ball")));
    steps(&mut app, 30);
    let all = texts(&mut app);
    assert!(shows(&mut app, "cube 1: hit by ball"), "{all:?}");
    let ago = all
        .iter()
        .position(|text| text == "cube 1: hit by ball")
        .unwrap();
    let seconds: f32 = all[ago - 1].strip_suffix(" s").unwrap().parse().unwrap();
    assert!((0.1..0.5).contains(&seconds), "{seconds}");
}

#[test]
fn nothing_but_bars_and_texts_changes_while_it_is_shown() {
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
    steps(&mut app, 2);
    // Bars have a share of their trough as width.
    let fixed = |nodes: Vec<(Entity, Node)>| {
        let is_fixed = |node: &(Entity, Node)| !matches!(node.1.width, Val::Percent(_));
        nodes.into_iter().filter(is_fixed).collect::<Vec<_>>()
    };
    let before = fixed(nodes(&mut app));
    assert!(before.len() > 40);
    steps(&mut app, 200);
    assert_eq!(fixed(nodes(&mut app)), before);
    // Only the place follows the settings.
    let place = UiRect::new(Val::Px(4.0), Val::Auto, Val::Auto, Val::Px(4.0));
    app.world_mut().resource_mut::<PhysicsPanel>().place = place;
    app.update();
    assert!(
        nodes(&mut app)
            .iter()
            .any(|(_, node)| node.bottom == Val::Px(4.0))
    );
}

/// The panel's entities have names and parents, as bodies do.
#[test]
fn snapshots_leave_it_alone() {
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
    steps(&mut app, 2);
    let snapshot = Snapshot::take(app.world());
    app.world_mut().resource_mut::<PhysicsPanel>().shown = false;
    app.update();
    snapshot.restore(app.world_mut()).unwrap();
    let nodes = nodes(&mut app);
    assert!(nodes.is_empty(), "{nodes:?}");
    let mut named = app.world_mut().query::<&Name>();
    assert_eq!(named.iter(app.world()).count(), 3);
}

#[test]
fn it_comes_back_if_somebody_despawns_it() {
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
    steps(&mut app, 2);
    let world = app.world_mut();
    let mut roots = world.query_filtered::<Entity, (With<Node>, Without<ChildOf>)>();
    let root = roots.single(world).unwrap();
    world.despawn(root);
    app.update();
    assert!(shows(&mut app, "narrowphase"));
}
