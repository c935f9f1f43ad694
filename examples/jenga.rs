//! A player of Jenga, who looks before it pulls: takes planks out of a tower and lays them on top, until nothing is safe.
//!
//! Before each move it asks of one plank after the other, those first that bear least, what would fall without it ([`preview`]), pulls it
//! out on a copy of the tower ([`Shadow`]), and asks how far that could be tilted then ([`stability`]). It takes the first that is safe,
//! and ends when none is.
//!
//! ```text
//! cargo run --release -p drystone-examples --features stability --example jenga -- [LAYERS [LEAST_TILT_IN_DEGREES]]
//! ```
//!
//! It prints the tower and leaves pictures of it in `target/jenga/`.

use bevy_app::App;
use bevy_ecs::prelude::*;
use drystone::body::{ExternalForce, MassProperties, Velocity};
use drystone::masonry::Tower;
use drystone::prelude::*;
use drystone::stability::{Trial, stability};
use drystone_lab::pictures::{Camera, frame, save};
use glam::Quat;
use std::error::Error;
use std::f32::consts::FRAC_PI_2;
use std::path::Path;

/// s
const DT: f32 = 1.0 / 60.0;
/// How fast it pulls, m/s, and how hard at most, in weights of a plank.
const SPEED: f32 = 0.2;
const STRENGTH: f32 = 20.0;
/// A plank that has gone so far has fallen, m.
const FALLEN: f32 = 0.1;
/// Moves, at most.
const MOVES: usize = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1).map(|text| text.parse::<f32>());
    let layers = numbers.next().transpose()?.unwrap_or(12.0);
    let least = numbers.next().transpose()?.unwrap_or(3.0).to_radians();
    let mut game = Game::new(layers as u32)?;
    game.picture("start")?;
    for number in 1..=MOVES {
        let Some((best, tilt)) = game.think(least) else {
            println!("nothing is safe any more");
            break;
        };
        println!(
            "{number}: layer {}, place {}; then it stands up to {:.1}°",
            best.layer + 1,
            best.place + 1,
            tilt.to_degrees()
        );
        if !game.play(&best)? {
            println!("it fell");
            break;
        }
        if number % 5 == 0 {
            game.picture(&format!("{number:02}"))?;
        }
    }
    game.print();
    game.picture("end")
}

/// A tower, and who lies where.
struct Game {
    world: World,
    shape: Tower,
    layers: Vec<[Option<Entity>; 3]>,
}

/// A plank that may be taken, and in which of its two directions.
#[derive(Clone, Copy)]
struct Move {
    layer: usize,
    place: usize,
    way: f32,
}

impl Game {
    fn new(layers: u32) -> Result<Self, Box<dyn Error>> {
        let mut app = App::new();
        app.add_plugins(DrystonePlugins::default());
        let mut world = std::mem::take(app.world_mut());
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let shape = Tower {
            layers,
            ..Default::default()
        };
        let planks = shape.blocks()?.into_iter();
        let planks = planks.map(|plank| world.spawn((plank.bundle(), Load::default())).id());
        let planks: Vec<Entity> = planks.collect();
        let (layers, _) = planks.as_chunks::<3>();
        let mut game = Self {
            world,
            shape,
            layers: layers.iter().map(|layer| layer.map(Some)).collect(),
        };
        game.run(1.0)?;
        Ok(game)
    }

    fn run(&mut self, seconds: f32) -> Result<(), StepError> {
        (0..(seconds / DT).round() as usize).try_for_each(|_| drystone::step(&mut self.world, DT))
    }

    fn planks(&self) -> impl Iterator<Item = Entity> {
        self.layers.iter().flatten().flatten().copied()
    }

    /// The first move that is safe, of the planks that bear least first, and how far the tower can be tilted after it, rad.
    fn think(&self, least: f32) -> Option<(Move, f32)> {
        // By the rules not from the highest layer that is whole, nor from above it.
        let is_whole = |layer: &[Option<Entity>; 3]| layer.iter().all(Option::is_some);
        let whole = self.layers.iter().rposition(is_whole)?;
        let mut planks = Vec::new();
        for (layer, planks_of) in self.layers[..whole].iter().enumerate() {
            for (place, plank) in planks_of.iter().enumerate() {
                planks.extend(plank.map(|plank| (plank, layer, place)));
            }
        }
        let bears = |plank: Entity| {
            self.world
                .get::<Load>(plank)
                .map_or(0.0, |load| load.supported_weight)
        };
        planks.sort_by(|a, b| bears(a.0).total_cmp(&bears(b.0)));
        for (plank, layer, place) in planks {
            let falls = preview(&self.world, &Edit::Remove(vec![plank]));
            if !falls.is_ok_and(|preview| preview.moved.is_empty()) {
                continue;
            }
            for way in [1.0, -1.0] {
                let best = Move { layer, place, way };
                let tilt = self.rehearse(&best);
                if let Some(tilt) = tilt.filter(|tilt| *tilt >= least) {
                    return Some((best, tilt));
                }
            }
        }
        None
    }

    /// Makes a move on a copy of the tower: how far that can be tilted then, in the worst of four directions, rad; nothing where it falls.
    fn rehearse(&self, best: &Move) -> Option<f32> {
        let planks: Vec<Entity> = self.planks().collect();
        let shadow = Shadow::around(&self.world, &planks).ok()?;
        let copies = self.layers.iter();
        let copies = copies.map(|layer| layer.map(|plank| shadow.copy_of(plank?)));
        let mut copy = Self {
            layers: copies.collect(),
            shape: self.shape,
            world: shadow.into_world(),
        };
        // Copies have no mass before their first step.
        copy.run(DT).ok()?;
        if !copy.play(best).ok()? {
            return None;
        }
        let planks: Vec<Entity> = copy.planks().collect();
        let mut least = f32::INFINITY;
        for direction in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z] {
            let margin = stability(&copy.world, &planks, &Trial::Tilt(direction));
            least = least.min(margin.ok()?.limit);
        }
        Some(least)
    }

    /// Pulls a plank out by its end, and lays it on top; false where anything else has fallen then.
    fn play(&mut self, best: &Move) -> Result<bool, Box<dyn Error>> {
        let plank = self.layers[best.layer][best.place].take();
        let plank = plank.ok_or("nothing lies there")?;
        let others: Vec<(Entity, Pose)> = self
            .planks()
            .map(|other| (other, self.pose(other)))
            .collect();
        let Pose { position, rotation } = self.pose(plank);
        let mass = self.world.get::<MassProperties>(plank);
        let mass = mass.ok_or("a plank has no mass")?.mass();
        let out = best.way * (rotation * Vec3::X * self.shape.plank.x);
        let (layer, place, laid) = self.next_place();
        // Out by not quite a half, by a finger that neither lifts nor presses down: a level force that keeps a steady speed.
        let mut force = 0.0;
        let mut patience = (10.0 / DT) as usize;
        while self.pose(plank).position.distance(position) < 0.45 * self.shape.plank.x {
            let velocity = self.world.get::<Velocity>(plank).copied();
            let speed = velocity.unwrap_or_default().linear.dot(out.normalize());
            force = (force + mass * (SPEED - speed)).clamp(0.0, STRENGTH * mass * 9.81);
            let finger = ExternalForce {
                force: force * out.normalize(),
                torque: Vec3::ZERO,
                ..Default::default()
            };
            self.world.entity_mut(plank).insert(finger);
            self.run(DT)?;
            if patience == 0 {
                return Ok(false);
            }
            patience -= 1;
        }
        self.world
            .entity_mut(plank)
            .insert(ExternalForce::default());
        // Then it is carried: where to, how turned, and how long it takes, s.
        let Pose { position, rotation } = self.pose(plank);
        let above = self.layers.len() as f32 * self.shape.plank.y + 0.5;
        let aside = position + 0.75 * out;
        let ways = [
            (aside, rotation, 2.0),
            (aside.with_y(above), rotation, 2.0),
            (aside.with_y(above), laid.rotation, 1.0),
            (laid.position.with_y(above), laid.rotation, 2.0),
            (laid.position + Vec3::Y * 0.05, laid.rotation, 1.5),
            (laid.position, laid.rotation, 1.0),
        ];
        let mut from = position;
        for (to, rotation, seconds) in ways {
            let steps = (seconds / DT) as usize;
            for step in 1..=steps {
                let target = from.lerp(to, step as f32 / steps as f32);
                let carry = Grab {
                    rotation: Some(rotation),
                    ..Grab::gentle(mass, Vec3::ZERO, target)
                };
                self.world.entity_mut(plank).insert(carry);
                self.run(DT)?;
            }
            from = to;
        }
        self.run(0.3)?;
        self.world.entity_mut(plank).remove::<Grab>();
        self.run(1.5)?;
        if layer == self.layers.len() {
            self.layers.push([None; 3]);
        }
        self.layers[layer][place] = Some(plank);
        let stays = |(other, before): &(Entity, Pose)| {
            self.pose(*other).position.distance(before.position) < FALLEN
        };
        let lies = self.pose(plank).position.distance(laid.position) < FALLEN;
        Ok(lies && others.iter().all(stays))
    }

    /// The layer, the index and the pose of the next plank on top, which follow from the planks of the layer below.
    fn next_place(&self) -> (usize, usize, Pose) {
        let free = self
            .layers
            .last()
            .and_then(|top| top.iter().position(Option::is_none));
        let (layer, place) = match free {
            Some(place) => (self.layers.len() - 1, place),
            None => (self.layers.len(), 0),
        };
        let below = self.layers[layer - 1].iter().flatten();
        let below: Vec<Vec3> = below.map(|&plank| self.pose(plank).position).collect();
        let middle = below.iter().sum::<Vec3>() / below.len() as f32;
        let rotation = match layer % 2 {
            0 => Quat::IDENTITY,
            _ => Quat::from_rotation_y(FRAC_PI_2),
        };
        let Tower {
            plank, lateral_gap, ..
        } = self.shape;
        let aside = (place as f32 - 1.0) * (plank.z + lateral_gap);
        let position = middle + Vec3::Y * plank.y + rotation * Vec3::Z * aside;
        (layer, place, Pose { position, rotation })
    }

    fn pose(&self, plank: Entity) -> Pose {
        self.world.get::<Pose>(plank).copied().unwrap_or_default()
    }

    fn print(&self) {
        for (number, layer) in self.layers.iter().enumerate().rev() {
            let planks = layer.map(|plank| if plank.is_some() { "▆▆" } else { "··" });
            println!("{:3}  {}", number + 1, planks.join(" "));
        }
    }

    fn picture(&self, name: &str) -> Result<(), Box<dyn Error>> {
        let planks = self.layers.iter().flatten().flatten();
        let standing: Vec<(&Collider, &Pose)> = planks
            .filter_map(|&plank| {
                let plank = self.world.entity(plank);
                Some((plank.get::<Collider>()?, plank.get::<Pose>()?))
            })
            .collect();
        let height = self.layers.len() as f32 * self.shape.plank.y;
        let camera = Camera {
            target: Vec3::Y * (0.5 * height),
            height: 1.3 * height,
        };
        let pixels = frame(standing, None, &camera);
        let path = Path::new("target/jenga").join(format!("{name}.png"));
        save(&path, &pixels)?;
        println!("wrote {}", path.display());
        Ok(())
    }
}
