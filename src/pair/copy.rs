//! Copies of the components of a pair, for [snapshots](crate::snapshot).
//!
//! Most lists lie in the component itself, and their entries are plain numbers. They are [copied as a block](copy).

use super::{ContactAnchors, ContactImpulses, ContactTargets, Manifold};
use crate::stored::{copy, copy_into};

impl Clone for Manifold {
    fn clone(&self) -> Self {
        Self {
            patches: copy(&self.patches),
            points: copy(&self.points),
            between: self.between,
        }
    }

    fn clone_from(&mut self, from: &Self) {
        copy_into(&mut self.patches, &from.patches);
        copy_into(&mut self.points, &from.points);
        self.between = from.between;
    }
}

impl Clone for ContactTargets {
    fn clone(&self) -> Self {
        Self {
            points: self.points.clone(),
            patches: copy(&self.patches),
        }
    }

    fn clone_from(&mut self, from: &Self) {
        self.points.clone_from(&from.points);
        copy_into(&mut self.patches, &from.patches);
    }
}

impl Clone for ContactImpulses {
    fn clone(&self) -> Self {
        Self {
            points: copy(&self.points),
            patches: copy(&self.patches),
            friction: self.friction.clone(),
            earlier: self.earlier.clone(),
        }
    }

    fn clone_from(&mut self, from: &Self) {
        copy_into(&mut self.points, &from.points);
        copy_into(&mut self.patches, &from.patches);
        self.friction.clone_from(&from.friction);
        self.earlier.clone_from(&from.earlier);
    }
}

impl Clone for ContactAnchors {
    fn clone(&self) -> Self {
        Self {
            points: self.points.clone(),
            patches: copy(&self.patches),
            measured: self.measured,
        }
    }

    fn clone_from(&mut self, from: &Self) {
        self.points.clone_from(&from.points);
        copy_into(&mut self.patches, &from.patches);
        self.measured = from.measured;
    }
}
