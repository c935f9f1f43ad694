mod support;
use bevy_ecs::prelude::*;
use drystone::body::*;
use drystone::collider::*;
use drystone::settings::*;
use drystone::scenes::*;
use drystone::sleeping::*;
use glam::*;
use support::*;
#[test]
fn ghost() {
    let mut lab = Lab::new();
    lab.ground();
    let ghost = CollisionLayers { memberships: 0b10, filters: 0b10 };
    let cube = lab.cube(Vec3::Y * 0.5);
    let held = lab.cube(Vec3::new(3.0, 0.5, 0.0));
    lab.world.entity_mut(held).insert((ghost, GravityScale(0.0)));
    lab.run(2.0);
    lab.world.entity_mut(cube).insert(ghost);
    lab.world.entity_mut(held).remove::<GravityScale>();
    for _ in 0..4 { lab.step(); 
    for b in [cube, held] { println!("rel {:?} {:?} {:?}", lab.position(b), lab.velocity(b), lab.world.get::<Sleeping>(b)); } }
}
#[test]
fn wake() {
  for sleep in [false,true] {
    let mut lab = Lab::new();
    lab.dt = 0.1;
    let built = Scene::Wall(6, 6).build(&mut lab.world, &SceneOptions::default());
    let beside = lab.body(Collider::cuboid(0.5, 0.5, 0.5), Vec3::new(3.25, 0.25, 0.0));
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab.run(60.0);
    lab.world.resource_mut::<SleepSettings>().enabled = sleep;
    lab.run(2.0);
    println!("rel asleep {:?}", lab.world.get::<Sleeping>(built.bodies[8]));
    let before: Vec<Vec3> = built.bodies.iter().map(|&b| lab.position(b)).collect();
    lab.world.despawn(beside);
    for i in 0..20 {
      lab.step();
      let (mut w, mut wi)=(0f32,0);
      for (k,(&b,p)) in built.bodies.iter().zip(&before).enumerate() { let d=(lab.position(b)-*p).length(); if d>w {w=d;wi=k;} }
      println!("rel {sleep} {i} worst {wi} {:.3} mm {:?}", w*1e3, (lab.position(built.bodies[wi])-before[wi])*1e3);
    }
  }
}
