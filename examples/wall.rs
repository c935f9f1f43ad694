//! The README's app: a wall that a Bevy app without a window builds, and watches stand.
//!
//! ```text
//! cargo run --release --example wall
//! ```

use bevy_app::{ScheduleRunnerPlugin, prelude::*};
use bevy_ecs::prelude::*;
use bevy_log::LogPlugin;
use bevy_time::{TimePlugin, common_conditions::on_timer, prelude::*};
use bevy_transform::prelude::*;
use drystone::masonry::{Bond, Wall};
use drystone::prelude::*;
use std::time::Duration;

fn main() {
    App::new()
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::from_millis(16)))
        .add_plugins((TimePlugin, TransformPlugin))
        .add_plugins(LogPlugin::default()) // drystone names bodies with invalid input there
        .add_plugins(DrystonePlugins::default()) // steps in FixedPostUpdate; DrystonePlugins::new(Update) elsewhere
        .add_systems(Startup, build)
        .add_systems(Update, watch.run_if(on_timer(Duration::from_secs(1))))
        .run();
}

fn build(mut commands: Commands) {
    commands.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let wall = Wall {
        length: 10.0,
        courses: 10,
        ..Wall::new(Bond::Running)
    };
    for brick in wall.blocks().expect("there is room for it") {
        commands.spawn(brick.bundle()); // RigidBody::Dynamic, Collider::cuboid(..), Transform
    }
}

fn watch(time: Res<Time>, bricks: Query<(&RigidBody, &Transform)>) {
    let heights = bricks.iter().map(|(_, at)| at.translation.y);
    let (seconds, top) = (time.elapsed_secs(), heights.fold(0.0, f32::max));
    println!("{seconds:.0} s: the top course is {top:.4} m up");
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_time::TimeUpdateStrategy;

    #[test]
    fn the_readme_has_it() {
        let readme = include_str!("../README.md");
        let (_, code) = include_str!("wall.rs").split_once("```\n\n").unwrap();
        let (code, _) = code.split_once("\n#[cfg(test)]").unwrap();
        assert!(readme.contains(&format!("```rust,no_run\n{code}```")));
    }

    /// How far a brick has ever been from where it was put, m.
    #[derive(Resource, Default)]
    struct Worst(f32);

    #[derive(Component)]
    struct Put(Vec3);

    fn put(mut commands: Commands, bricks: Query<(Entity, &Transform), With<RigidBody>>) {
        for (brick, at) in &bricks {
            commands.entity(brick).insert(Put(at.translation));
        }
    }

    fn look(bricks: Query<(&Put, &Transform)>, mut worst: ResMut<Worst>) {
        for (put, at) in &bricks {
            worst.0 = worst.0.max(at.translation.distance(put.0));
        }
    }

    #[test]
    fn its_wall_stands() {
        let frame = Duration::from_millis(16);
        let mut app = App::new();
        app.add_plugins((TimePlugin, TransformPlugin))
            .add_plugins(DrystonePlugins::default())
            .insert_resource(TimeUpdateStrategy::ManualDuration(frame))
            .init_resource::<Worst>()
            .add_systems(Startup, build)
            .add_systems(PostStartup, put)
            .add_systems(Update, look);
        for _ in 0..625 {
            app.update();
        }
        let bricks = app.world_mut().query::<&Put>().iter(app.world()).count();
        assert_eq!(bricks, 106, "and the ground");
        let worst = app.world().resource::<Worst>().0;
        assert!(worst < 1e-3, "a brick was {worst} m off");
    }
}
