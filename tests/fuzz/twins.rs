//! Pairs of worlds to which the same is done, and in which the same must come of it.

use crate::dice::{Dice, spoils};
use crate::operation::{Act, Operation};
use crate::part::Part;
use crate::run::roll;
use crate::site::Site;
use bevy_ecs::prelude::*;
use drystone::body::{Pose, Velocity};

/// The additional action in the second world.
pub type Besides = fn(&mut Site, &mut Dice);

/// Entities come and go between the bodies, and put them elsewhere in the world.
pub fn junk(site: &mut Site, dice: &mut Dice) {
    let world = &mut site.noisy.world;
    let all: Vec<Entity> = (0..dice.index(8))
        .map(|_| world.spawn_empty().id())
        .collect();
    for entity in all {
        if dice.chance(0.5) {
            world.despawn(entity);
        }
    }
}

/// Components are written without change.
pub fn touch(site: &mut Site, dice: &mut Dice) {
    let operation = Operation::Touch(dice.index(64), Part::roll(dice));
    let bad = false;
    site.act(&Act { operation, bad });
}

/// # Panics
/// If an episode ends otherwise if something is done besides, which must not matter.
pub fn same(seed: u64, besides: Besides) {
    let mut twins = [Site::new(spoils(seed)), Site::new(spoils(seed))];
    let mut dice = Dice::new(2 * seed);
    for (i, act) in roll(seed).iter().enumerate() {
        besides(&mut twins[1], &mut dice);
        for twin in &mut twins {
            twin.act(act);
        }
        let [one, other] = [&twins[0], &twins[1]].map(bits);
        assert_eq!(
            one, other,
            "seed {seed}, operation {i}: {:?}",
            act.operation
        );
    }
}

fn bits(site: &Site) -> Vec<Option<[u32; 13]>> {
    let of = |&guest: &Entity| {
        let pose = site.noisy.world.get::<Pose>(guest)?;
        let velocity = site.noisy.world.get::<Velocity>(guest)?;
        let numbers = [
            pose.position.to_array().as_slice(),
            &pose.rotation.to_array(),
            &velocity.linear.to_array(),
            &velocity.angular.to_array(),
        ]
        .concat();
        Some(std::array::from_fn(|i| numbers[i].to_bits()))
    };
    site.guests.iter().map(of).collect()
}
