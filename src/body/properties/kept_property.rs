//! Validation of the properties that the table copies.

use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;

/// A property that the table copies. A body without the component has the default value.
pub(crate) trait KeptProperty: Component + Clone + Default + PartialEq {
    /// Validates the value.
    ///
    /// # Errors
    /// If the value is invalid. The body is then quarantined.
    fn check(&self) -> Result<(), BodyProblem> {
        Ok(())
    }
}
