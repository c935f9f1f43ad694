//! Collision layers by name: enums whose variants are layers.

use super::CollisionLayers;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use std::ops::{BitOr, Not};

/// A set of up to 32 layers, as bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerMask(pub u32);

impl LayerMask {
    /// No layer.
    pub const NONE: Self = Self(0);
    /// All layers.
    pub const ALL: Self = Self(u32::MAX);
}

impl BitOr for LayerMask {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for LayerMask {
    type Output = Self;

    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// A type whose values are layers. [`collision_layers!`](crate::collision_layers) implements it for an enum.
pub trait CollisionLayer {
    /// The number of the layer, below 32.
    fn number(&self) -> u32;
}

impl<L: CollisionLayer> From<L> for LayerMask {
    fn from(layer: L) -> Self {
        Self(1 << layer.number())
    }
}

impl<L: CollisionLayer, const N: usize> From<[L; N]> for LayerMask {
    fn from(layers: [L; N]) -> Self {
        let masks = layers.into_iter().map(Self::from);
        masks.fold(Self::NONE, BitOr::bitor)
    }
}

impl From<u32> for LayerMask {
    fn from(bits: u32) -> Self {
        Self(bits)
    }
}

impl CollisionLayers {
    /// A body in these layers that collides with those.
    ///
    /// ```
    /// use drystone::collision_layers;
    /// use drystone::prelude::*;
    ///
    /// collision_layers! {
    ///     /// What collides with what in this game.
    ///     pub enum GameLayer { Ground, Brick, Ghost }
    /// }
    ///
    /// let brick = CollisionLayers::new(GameLayer::Brick, LayerMask::ALL);
    /// let ghost = CollisionLayers::new(GameLayer::Ghost, [GameLayer::Ground, GameLayer::Ghost]);
    /// assert!(!brick.collides_with(ghost) && brick.collides_with(brick));
    /// ```
    pub fn new(memberships: impl Into<LayerMask>, filters: impl Into<LayerMask>) -> Self {
        Self {
            memberships: memberships.into().0,
            filters: filters.into().0,
        }
    }
}

/// Defines an enum whose variants are [collision layers](crate::collider::CollisionLayer), in their order. More than 32 do not compile.
///
/// ```compile_fail
/// drystone::collision_layers! {
///     enum TooMany {
///         A, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, Q, R, S, T, U, V, W, X, Y, Z, A1, B1, C1, D1, E1, F1, G1
///     }
/// }
/// ```
#[macro_export]
macro_rules! collision_layers {
    ($(#[$meta:meta])* $visibility:vis enum $name:ident { $($(#[$of_layer:meta])* $layer:ident),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        $visibility enum $name {
            $($(#[$of_layer])* $layer,)+
        }

        const _: () = assert!(
            [$($name::$layer),+].len() <= 32,
            "there are 32 collision layers"
        );

        impl $crate::body::collider::CollisionLayer for $name {
            fn number(&self) -> u32 {
                *self as u32
            }
        }
    };
}
