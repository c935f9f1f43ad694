//! The engines beside which drystone is put.

use crate::engine::Engine;
use crate::rapier::{self, Rapier};
use crate::scene::Start;

/// Another engine.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Peer {
    /// Rapier 0.36.
    Rapier,
    /// Box3D 0.1; with the feature `box3d`.
    #[value(name = "box3d")]
    Box3d,
}

impl Peer {
    /// Those that this build has.
    pub const BUILT: &[Self] = if cfg!(feature = "box3d") {
        &[Self::Rapier, Self::Box3d]
    } else {
        &[Self::Rapier]
    };

    /// Puts a scene into it.
    ///
    /// # Errors
    /// If this build has no such engine, or it cannot have the scene or the threads.
    pub fn start(self, start: &Start, rapier: rapier::Options) -> Result<Box<dyn Engine>, String> {
        match self {
            Self::Rapier => Ok(Box::new(Rapier::new(start, rapier)?)),
            #[cfg(feature = "box3d")]
            Self::Box3d => Ok(Box::new(crate::box3d::Box3d::new(start)?)),
            #[cfg(not(feature = "box3d"))]
            Self::Box3d => {
                Err("--engine box3d: this build has no Box3D; build with --features box3d".into())
            }
        }
    }
}
