mod support;
use drystone::settings::*;
use drystone::scenes::*;
use drystone::contact::*;
use glam::*;
use support::*;
#[test]
fn alt() {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    let built = Scene::Stack(5).build(&mut lab.world, &SceneOptions::default());
    for i in 0..60 {
      lab.dt = if i%2==0 {1.0/60.0} else {1e-4};
      lab.step();
      let b=built.bodies[0];
      let mut s=0.0; let mut l=0.0; let mut w=0.0; let mut d=0f32;
      let mut q=lab.world.query::<(&ContactPair,&Manifold,&ContactImpulses)>();
      for (p,m,im) in q.iter(&lab.world) { if p.bodies[1]==b || p.bodies[0]==b { if p.ages[0].0==0 { for (x,c) in im.points.iter().zip(&m.points) { s+=x.normal; l+=x.load; w+=x.warm_normal; d=d.min(c.distance);} } } }
      println!("rel {i} dt {:.4} y {:.6} mm v {:?} F {:.1} warm {:.1} load {:.1} d {:.6}mm", lab.dt, (lab.position(b).y-0.5)*1e3, lab.velocity(b).linear.y, s/lab.dt, w, l, d*1e3);
    }
}
