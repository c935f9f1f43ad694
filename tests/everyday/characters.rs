use super::*;

#[test]
fn scratch() {
    let mut app = app();
    let world = app.world_mut();
    for i in 0..40 {
        let x = i as f32 - 19.5;
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 3.0, 1.0),
            at(x, 1.5, 1.0),
        ));
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 1.0, 4.0),
            at(x, -0.5, 0.0),
        ));
    }
    steps(world, 1);
    let shape = Collider::cuboid(0.6, 1.6, 0.6);
    let mut pose = Pose {
        position: Vec3::new(-15.0, 0.812, 0.15),
        ..Pose::default()
    };
    for k in 0..300 {
        let way = Vec3::new(4.0, 0.0, 2.0) * DT;
        let before = pose.position;
        let slide = spatial_query(world, |query| {
            query.move_and_slide(
                &shape,
                pose,
                way,
                &MoveAndSlide::default(),
                &QueryFilter::default(),
            )
        })
        .unwrap();
        pose.position = slide.position;
        let went = pose.position.x - before.x;
        if (went - 4.0 * DT).abs() > 1e-4 || k < 3 {
            println!("{k} from {before:?} went {went} {:?}", slide);
        }
    }
    println!("{}", pose.position.x + 15.0);
}
