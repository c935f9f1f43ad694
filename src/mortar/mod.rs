//! Mortar: bonds between bricks that hold tension and shear, and break patch by patch.
//!
//! Put [`Mortar`] on a brick and lay it: in the first step in which a face of it rests on faces of other bodies, it is bonded to them, and the
//! component is removed. Each patch of contact is a bond of its own, an entity with [`MortarJoint`]. When the stress in a patch exceeds its
//! strength the bond breaks: [`MortarBroke`] is sent, and the bricks touch as dry stone from then on.
//!
//! ```
//! use bevy_ecs::message::Messages;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! // Three bricks of 125 kg stick out of a wall, 1.5 m in all.
//! let cube = Collider::cuboid(0.5, 0.5, 0.5);
//! let at = |x: f32, y: f32| Transform::from_xyz(x, y, 0.0);
//! world.spawn((RigidBody::Static, cube.clone(), at(0.0, 3.0)));
//! for i in 1..=3 {
//!     let brick = (RigidBody::Dynamic, cube.clone(), Mass(125.0), Mortar::default());
//!     world.spawn((brick, at(0.5 * i as f32, 3.0)));
//! }
//! # let mut run = |world: &mut World| (0..60).for_each(|_| drystone::step(world, 1.0 / 60.0).unwrap());
//! # use bevy_ecs::world::World;
//! run(world);
//! // The root bears M = m g L/2 = 2.8 kN·m, so the tension is M/W = 0.13 MPa above a neutral axis: more than the default 0.1 MPa.
//! let broke: Vec<_> = world.resource_mut::<Messages<MortarBroke>>().drain().collect();
//! ```
mod events;
mod joint;
mod lay;
mod patch;

pub use crate::solver::MortarFailure;
#[doc(hidden)]
pub use events::BrokenMortar;
pub(crate) use events::trigger;
pub use events::{MortarBroke, mortar_events};
pub use joint::MortarJoint;
#[cfg(feature = "gizmos")]
pub(crate) use joint::corners;
pub use lay::lay_mortar;

use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Fresh mortar on a body: in the first step in which it rests on other bodies, face to face, it is bonded to all of them, and the component
/// is removed. Insert it again to bond the body to what it touches by then.
///
/// The default has the characteristic strengths of clay bricks in a common cement mortar (EN 1996-1-1, 3.6: M2.5 to M9).
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
pub struct Mortar {
    /// Tensile strength, Pa. Default: 100 kPa.
    pub tensile_strength: f32,
    /// Shear strength without pressure, Pa. Default: 200 kPa.
    pub cohesion: f32,
    /// Shear strength gained per pressure on the patch. Default: 0.4. It acts while the bond holds; then the friction of the bodies does.
    pub friction: f32,
}

impl Default for Mortar {
    fn default() -> Self {
        Self {
            tensile_strength: 1e5,
            cohesion: 2e5,
            friction: 0.4,
        }
    }
}

impl Mortar {
    /// Mortar of these tensile and shear strengths, Pa.
    pub fn new(tensile_strength: f32, cohesion: f32) -> Self {
        Self {
            tensile_strength,
            cohesion,
            ..Self::default()
        }
    }

    /// The lesser strength of each kind.
    fn weaker(&self, other: &Self) -> Self {
        Self {
            tensile_strength: self.tensile_strength.min(other.tensile_strength),
            cohesion: self.cohesion.min(other.cohesion),
            friction: self.friction.min(other.friction),
        }
    }

    fn is_valid(&self) -> bool {
        // A comparison with NaN is false.
        self.tensile_strength >= 0.0 && self.cohesion >= 0.0 && self.friction >= 0.0
    }
}
