//! Bodies slide and roll over seams between flush surfaces as over one surface.

use super::*;
use std::f32::consts::FRAC_PI_2;

/// A surface of height 0 that is made of tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    /// One cuboid.
    Whole,
    /// Bodies that are cuboids of this size, m.
    Bodies(f32),
    /// Kinematic bodies that are cuboids of 1 m.
    Kinematic,
    /// Hexagonal bodies, as on a map of a strategy game.
    Hexagons,
    /// One body with a compound of cuboids of 1 m.
    Compound,
    /// One body with cuboids of 1 m on children.
    Children,
    /// Height fields of 4 m with eight cells on each side.
    Fields,
    /// Meshes of 4 m, each of two triangles.
    Meshes,
    /// Meshes beside height fields.
    Mixed,
}

/// The frame of a scene: all poses and velocities are given in it.
#[derive(Clone, Copy, Debug)]
struct Frame {
    turn: f32,
    far: f32,
}

impl Frame {
    fn pose(&self, local: Transform) -> Transform {
        let turn = Quat::from_rotation_y(self.turn);
        Transform {
            translation: turn * local.translation + Vec3::new(self.far, 0.0, 0.5 * self.far),
            rotation: turn * local.rotation,
            ..local
        }
    }

    fn way(&self, local: Vec3) -> Vec3 {
        Quat::from_rotation_y(self.turn) * local
    }
}

const HERE: Frame = Frame {
    turn: 0.0,
    far: 0.0,
};
const TURNED: Frame = Frame {
    turn: 0.7,
    far: 0.0,
};
const FAR: Frame = Frame {
    turn: 0.3,
    far: 1000.0,
};

/// A hexagonal tile, 1 m wide from corner to corner.
fn hexagon() -> Collider {
    let corners = |y: f32| {
        (0..6).map(move |i| {
            Quat::from_rotation_y(i as f32 * std::f32::consts::FRAC_PI_3) * Vec3::new(0.0, y, 0.5)
        })
    };
    Collider::convex_hull(&corners(-0.2).chain(corners(0.2)).collect::<Vec<_>>()).unwrap()
}

/// A surface of 4 × 4 m: a height field or a mesh, which alternate in a mixed floor.
fn surface(floor: Floor, is_even: bool) -> Collider {
    let field = Collider::height_field(&vec![vec![0.0; 9]; 9], Vec3::new(4.0, 1.0, 4.0)).unwrap();
    let corners = [[-2.0, -2.0], [-2.0, 2.0], [2.0, 2.0], [2.0, -2.0]];
    let corners = corners.map(|[x, z]| Vec3::new(x, 0.0, z));
    let mesh = Collider::trimesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    match floor {
        Floor::Fields => field,
        Floor::Mixed if is_even => field,
        _ => mesh,
    }
}

/// Builds a floor of some 24 × 6 m from x = −2 on.
fn lay(world: &mut World, floor: Floor, friction: Friction, frame: Frame) {
    let tile = |world: &mut World, kind: RigidBody, collider: Collider, x: f32, y: f32, z: f32| {
        world.spawn((kind, collider, friction, frame.pose(at(x, y, z))));
    };
    let cells = || (-2..22).flat_map(|x| (-3..=3).map(move |z| (x as f32 + 0.5, z as f32)));
    match floor {
        Floor::Whole => tile(
            world,
            RigidBody::Static,
            Collider::cuboid(24.0, 1.0, 7.0),
            10.0,
            -0.5,
            0.0,
        ),
        Floor::Bodies(size) => {
            for (x, z) in (0..(24.0 / size) as i32)
                .flat_map(|x| (0..(6.0 / size) as i32).map(move |z| (x, z)))
            {
                let [x, z] = [x, z].map(|i| (i as f32 + 0.5) * size);
                tile(
                    world,
                    RigidBody::Static,
                    cube(size),
                    x - 2.0,
                    -0.5 * size,
                    z - 3.0,
                );
            }
        }
        Floor::Kinematic => {
            cells().for_each(|(x, z)| tile(world, RigidBody::Kinematic, cube(1.0), x, -0.5, z))
        }
        Floor::Hexagons => {
            let hexagon = hexagon();
            let width = 3f32.sqrt() * 0.5;
            for (x, z) in (0..26).flat_map(|x| (-4..5).map(move |z| (x, z))) {
                let shift = 0.5 * (z & 1) as f32;
                tile(
                    world,
                    RigidBody::Static,
                    hexagon.clone(),
                    (x as f32 + shift) * width - 2.0,
                    -0.2,
                    0.75 * z as f32,
                );
            }
        }
        Floor::Compound => {
            let parts = cells().map(|(x, z)| (Vec3::new(x, -0.5, z), Quat::IDENTITY, cube(1.0)));
            let whole = Collider::compound(parts.collect()).unwrap();
            tile(world, RigidBody::Static, whole, 0.0, 0.0, 0.0);
        }
        Floor::Children => {
            let body = world
                .spawn((RigidBody::Static, friction, frame.pose(at(0.0, 0.0, 0.0))))
                .id();
            for (x, z) in cells() {
                world.spawn((cube(1.0), friction, at(x, -0.5, z), ChildOf(body)));
            }
        }
        Floor::Fields | Floor::Meshes | Floor::Mixed => {
            for (x, z) in (0..6).flat_map(|x| (-1..=1).map(move |z| (x, z))) {
                let collider = surface(floor, (x + z) % 2 == 0);
                tile(
                    world,
                    RigidBody::Static,
                    collider,
                    4.0 * x as f32,
                    0.0,
                    4.0 * z as f32,
                );
            }
        }
    }
}

/// A body that lies on the floor.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Ball,
    /// A capsule across the motion.
    Capsule,
    /// A capsule along the motion.
    CapsuleAhead,
    /// A cylinder on its side, across the motion.
    Cylinder,
    /// A cylinder on its end.
    Puck,
    /// A cone on its base.
    Cone,
    Cube,
    /// A cube that is turned by 0.4 rad about the vertical.
    TurnedCube,
    /// An octagonal prism on its base.
    Hull,
    /// Two balls one behind the other.
    Compound,
}

impl Shape {
    fn collider(self) -> (Collider, Quat, f32) {
        let none = Quat::IDENTITY;
        match self {
            Self::Ball => (Collider::ball(0.3), none, 0.3),
            Self::Capsule => (
                Collider::capsule(0.2, 0.4),
                Quat::from_rotation_x(FRAC_PI_2),
                0.2,
            ),
            Self::CapsuleAhead => (
                Collider::capsule(0.2, 0.4),
                Quat::from_rotation_z(FRAC_PI_2),
                0.2,
            ),
            Self::Cylinder => (
                Collider::cylinder(0.25, 0.5),
                Quat::from_rotation_x(FRAC_PI_2),
                0.25,
            ),
            Self::Puck => (Collider::cylinder(0.25, 0.2), none, 0.1),
            Self::Cone => (Collider::cone(0.25, 0.3), none, 0.15),
            Self::Cube => (cube(0.5), none, 0.25),
            Self::TurnedCube => (cube(0.5), Quat::from_rotation_y(0.4), 0.25),
            Self::Hull => {
                let ring = |y: f32| {
                    (0..8).map(move |i| {
                        Quat::from_rotation_y(i as f32 * FRAC_PI_2 / 2.0) * Vec3::new(0.3, y, 0.0)
                    })
                };
                let points: Vec<Vec3> = ring(-0.15).chain(ring(0.15)).collect();
                (Collider::convex_hull(&points).unwrap(), none, 0.15)
            }
            Self::Compound => {
                let parts = [-0.25, 0.25].map(|x| (Vec3::X * x, none, Collider::ball(0.2)));
                (Collider::compound(parts.to_vec()).unwrap(), none, 0.2)
            }
        }
    }

    fn rolls(self) -> bool {
        matches!(self, Self::Ball | Self::Capsule | Self::Cylinder)
    }
}

/// Velocity, spin and largest height above that at rest of a body that has crossed a floor, in the scene's frame.
#[derive(Debug)]
struct Crossing {
    speed: Vec3,
    spin: Vec3,
    height: f32,
}

/// Lets a body slide without friction, or roll, with 5 m/s over a floor.
fn cross(shape: Shape, floor: Floor, rolls: bool, frame: Frame, hz: f32) -> Crossing {
    let mut app = app();
    let world = app.world_mut();
    world.resource_mut::<SleepSettings>().enabled = false;
    let friction = match rolls {
        true => Friction::new(0.8),
        false => ice(),
    };
    lay(world, floor, friction, frame);
    let (collider, turn, height) = shape.collider();
    // A body that rolls and drifts aside would tip.
    let speed = Vec3::new(5.0, 0.0, if rolls { 0.0 } else { 0.31 });
    let spin = match rolls {
        true => Vec3::Y.cross(speed) / height,
        false => Vec3::ZERO,
    };
    let velocity = Velocity {
        linear: frame.way(speed),
        angular: frame.way(spin),
    };
    let start = frame.pose(at(0.0, height, -0.77).with_rotation(turn));
    let body = world
        .spawn((
            RigidBody::Dynamic,
            collider,
            friction,
            velocity,
            start,
            RollingFriction::new(0.0),
        ))
        .id();
    let mut highest = 0.0f32;
    for _ in 0..(3.0 * hz) as usize {
        steps_of(world, 1, 1.0 / hz);
        highest = highest.max(position(world, body).y - height);
    }
    let end = super::velocity(world, body);
    let back = |v: Vec3| Quat::from_rotation_y(-frame.turn) * v;
    Crossing {
        speed: back(end.linear),
        spin: back(end.angular),
        height: highest,
    }
}

/// Compares a crossing with that of a floor without seams. Returns what differs.
fn differs(shape: Shape, floor: Floor, rolls: bool, frame: Frame, hz: f32) -> Option<String> {
    let whole = cross(shape, Floor::Whole, rolls, frame, hz);
    let tiles = cross(shape, floor, rolls, frame, hz);
    let same = (tiles.speed - whole.speed).length() < 1e-3 * whole.speed.length()
        && (tiles.spin - whole.spin).length() < 0.01 * whole.spin.length().max(1.0)
        && tiles.height < whole.height + 1e-4;
    let kind = if rolls { "rolls" } else { "slides" };
    let text = || {
        format!(
            "{shape:?} {kind} over {floor:?}, {frame:?}, {hz} Hz: {tiles:?} instead of {whole:?}"
        )
    };
    (!same).then(text)
}

const SHAPES: [Shape; 10] = [
    Shape::Ball,
    Shape::Capsule,
    Shape::CapsuleAhead,
    Shape::Cylinder,
    Shape::Puck,
    Shape::Cone,
    Shape::Cube,
    Shape::TurnedCube,
    Shape::Hull,
    Shape::Compound,
];

const FLOORS: [Floor; 9] = [
    Floor::Bodies(1.0),
    Floor::Bodies(0.3),
    Floor::Kinematic,
    Floor::Hexagons,
    Floor::Compound,
    Floor::Children,
    Floor::Fields,
    Floor::Meshes,
    Floor::Mixed,
];

fn none(found: Vec<String>) {
    assert!(
        found.is_empty(),
        "{} differ:\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn all_shapes_slide_over_tiles_as_over_one_surface() {
    let all = FLOORS
        .into_iter()
        .flat_map(|floor| SHAPES.map(|shape| (shape, floor)));
    none(
        all.filter_map(|(shape, floor)| differs(shape, floor, false, HERE, 60.0))
            .collect(),
    );
}

#[test]
fn round_shapes_roll_over_tiles_as_over_one_surface() {
    let shapes = SHAPES.into_iter().filter(|shape| shape.rolls());
    let all = shapes.flat_map(|shape| FLOORS.map(|floor| (shape, floor)));
    // Parry's normals of a capsule on a hull are wrong by 10⁻⁴ rad, so it drifts aside.
    let all = all.filter(|case| !matches!(case, (Shape::Capsule, Floor::Hexagons)));
    none(
        all.filter_map(|(shape, floor)| differs(shape, floor, true, HERE, 60.0))
            .collect(),
    );
}

#[test]
fn tiles_far_from_the_origin_and_turned_are_one_surface_at_all_rates() {
    let mut found = Vec::new();
    for (frame, hz) in [(TURNED, 60.0), (FAR, 60.0), (HERE, 240.0), (HERE, 20.0)] {
        for shape in [
            Shape::Ball,
            Shape::CapsuleAhead,
            Shape::Cylinder,
            Shape::Hull,
        ] {
            for floor in [Floor::Bodies(1.0), Floor::Compound, Floor::Fields] {
                found.extend(differs(shape, floor, false, frame, hz));
            }
        }
    }
    none(found);
}

/// A ball rolls against an obstacle on a floor of cubes. Returns its speed and its height above the floor 1.5 s later.
fn against(obstacle: impl FnOnce(&mut World)) -> (f32, f32) {
    let mut app = app();
    let world = app.world_mut();
    for x in -3..3 {
        for z in -2..=2 {
            world.spawn((
                RigidBody::Static,
                cube(1.0),
                at(x as f32 - 0.5, -0.5, z as f32),
            ));
        }
    }
    obstacle(world);
    let ball = (
        RigidBody::Dynamic,
        Collider::ball(0.3),
        Restitution::new(0.0),
    );
    let ball = world
        .spawn((ball, Velocity::linear(Vec3::X * 3.0), at(-1.77, 0.3, 0.2)))
        .id();
    steps(world, 90);
    (
        super::velocity(world, ball).linear.x,
        position(world, ball).y - 0.3,
    )
}

/// The floor ends at x = 2.
#[test]
fn true_corners_are_no_seams() {
    let block = |x: f32, y: f32, size: Vec3| {
        let collider = Collider::cuboid(size.x, size.y, size.z);
        move |world: &mut World| {
            world.spawn((RigidBody::Static, collider, at(x, y, 0.0)));
        }
    };
    let (speed, height) = against(block(0.5, 0.5, Vec3::ONE));
    assert!(
        speed.abs() < 0.1 && height.abs() < 1e-3,
        "a wall: {speed}, {height}"
    );
    let (speed, height) = against(block(1.0, -0.49, Vec3::new(2.0, 1.0, 5.0)));
    assert!(
        speed < 2.95 && (height - 0.01).abs() < 3e-3,
        "a step of 1 cm: {speed}, {height}"
    );
    // Behind the floor is a hole.
    let (_, height) = against(|world| {
        let floor: Vec<Entity> = world
            .query_filtered::<(Entity, &Transform), With<RigidBody>>()
            .iter(world)
            .filter(|(_, at)| at.translation.x > 0.0)
            .map(|(id, _)| id)
            .collect();
        floor.into_iter().for_each(|id| {
            world.despawn(id);
        });
    });
    assert!(height < -1.0, "the edge of a table: {height}");
    let slope = 10f32.to_radians();
    let ramp = |world: &mut World| {
        let turn = Quat::from_rotation_z(slope);
        let at = Transform::from_translation(turn * Vec3::new(2.0, -0.5, 0.0)).with_rotation(turn);
        world.spawn((RigidBody::Static, Collider::cuboid(4.0, 1.0, 5.0), at));
    };
    let (speed, height) = against(ramp);
    assert!(
        speed < 2.6 && height > 0.1,
        "a slope of 10°: {speed}, {height}"
    );
}
