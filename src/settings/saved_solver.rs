//! A solver in a file (feature `serde`).

use super::ContactSolver;
use crate::solver::{Nncg, Pgs, SoftStep};
use serde::de::{Deserialize, Deserializer};
use serde::ser::{Error, Serialize, Serializer};

/// The solvers that a file can name.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "ContactSolver")]
enum BuiltIn {
    SoftStep(SoftStep),
    Pgs(Pgs),
    Nncg(Nncg),
}

impl Serialize for ContactSolver {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let solver = match self {
            Self::SoftStep(solver) => BuiltIn::SoftStep(*solver),
            Self::Pgs(solver) => BuiltIn::Pgs(*solver),
            Self::Nncg(solver) => BuiltIn::Nncg(*solver),
            Self::Patches(_) | Self::Points(_) => {
                return Err(S::Error::custom(format!(
                    "the solver `{}` is code and cannot be written to a file: leave `SolverSettings` out",
                    self.name()
                )));
            }
        };
        solver.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ContactSolver {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match BuiltIn::deserialize(deserializer)? {
            BuiltIn::SoftStep(solver) => Self::SoftStep(solver),
            BuiltIn::Pgs(solver) => Self::Pgs(solver),
            BuiltIn::Nncg(solver) => Self::Nncg(solver),
        })
    }
}
