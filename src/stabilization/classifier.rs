//! Classification of contacts as sticking or sliding, equation (10): a contact sticks if λ_n > 0 and ‖λ_t‖ < μ λ_n.
//!
//! The paper judges each point by itself, and calls that naive. Judged by the sums over a manifold, a slab just below its critical slope
//! creeps 300 times less, because the load on a single corner says little about the body.

use crate::pair::Anchor;
use crate::settings::Classifier;
use glam::Vec3;

/// The impulse at a contact point, N·s: λ_n and λ_t.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactImpulse {
    /// Normal impulse λ_n, N·s.
    pub normal: f32,
    /// Friction impulse λ_t, N·s, world axes.
    pub tangential: Vec3,
}

/// Share of the cone below which a contact sticks. A solved sliding contact lies on the cone only up to rounding.
const AT_THE_CONE: f32 = 0.999;

/// Share of the cone below which sticking begins with hysteresis.
const STICKING_CONE_SHARE: f32 = 0.6;

/// Sets `sticking` of every anchor of a manifold from the impulses of the last solve.
pub fn classify(rule: Classifier, friction: f32, given: &[ContactImpulse], anchors: &mut [Anchor]) {
    if rule == Classifier::PerPoint {
        for (anchor, given) in anchors.iter_mut().zip(given) {
            anchor.sticking = holds(friction, given, AT_THE_CONE);
        }
        return;
    }
    let was = anchors.iter().any(|a| a.sticking);
    let sum = ContactImpulse {
        normal: given.iter().map(|point| point.normal).sum(),
        tangential: given.iter().map(|point| point.tangential).sum(),
    };
    let sticking = sticks(rule, friction, &sum, given.iter().copied(), was);
    anchors
        .iter_mut()
        .for_each(|anchor| anchor.sticking = sticking);
}

/// Returns true if a manifold sticks as a whole, judged by the sum of its impulses or by its points. `was` says whether it stuck before.
/// With [`Classifier::PerPoint`] it sticks if any of its points does.
#[inline]
pub fn sticks(
    rule: Classifier,
    friction: f32,
    sum: &ContactImpulse,
    mut points: impl Iterator<Item = ContactImpulse>,
    was: bool,
) -> bool {
    match rule {
        Classifier::PerPoint | Classifier::Any => {
            points.any(|point| holds(friction, &point, AT_THE_CONE))
        }
        Classifier::All => {
            let mut loaded = points.filter(|point| point.normal > 0.0);
            sum.normal > 0.0 && loaded.all(|point| holds(friction, &point, AT_THE_CONE))
        }
        Classifier::Sum => holds(friction, sum, AT_THE_CONE),
        Classifier::Hysteresis => holds(
            friction,
            sum,
            if was {
                AT_THE_CONE
            } else {
                STICKING_CONE_SHARE
            },
        ),
    }
}

/// Equation (10), with a share of the cone.
#[inline]
fn holds(friction: f32, given: &ContactImpulse, share: f32) -> bool {
    given.normal > 0.0 && given.tangential.length() < share * friction * given.normal
}

/// Returns true if the points of a patch can hold the moment of friction `twist` about its normal, N·m·s. `lever` = Σ λ_n r, where r is
/// the distance of a point from the patch's centre, N·m·s.
#[inline]
pub fn holds_twist(friction: f32, twist: f32, lever: f32) -> bool {
    twist == 0.0 || twist.abs() < AT_THE_CONE * friction * lever
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(rule: Classifier, was: bool, impulses: &[(f32, f32)]) -> Vec<bool> {
        let impulses: Vec<ContactImpulse> = impulses
            .iter()
            .map(|&(normal, t)| ContactImpulse {
                normal,
                tangential: Vec3::X * t,
            })
            .collect();
        let mut anchors = vec![
            Anchor {
                sticking: was,
                ..Default::default()
            };
            impulses.len()
        ];
        classify(rule, 0.5, &impulses, &mut anchors);
        anchors.iter().map(|a| a.sticking).collect()
    }

    #[test]
    fn rules_differ_where_one_corner_slides_and_the_body_does_not() {
        let corner = [(1.0, 0.5), (9.0, 1.0), (0.0, 0.0)];
        assert_eq!(
            verdict(Classifier::PerPoint, false, &corner),
            [false, true, false]
        );
        assert_eq!(verdict(Classifier::Any, false, &corner), [true; 3]);
        assert_eq!(verdict(Classifier::All, false, &corner), [false; 3]);
        assert_eq!(verdict(Classifier::Sum, false, &corner), [true; 3]);
    }

    #[test]
    fn sliding_and_unloaded_manifolds_never_stick() {
        for rule in [
            Classifier::Any,
            Classifier::All,
            Classifier::Sum,
            Classifier::Hysteresis,
        ] {
            assert_eq!(
                verdict(rule, true, &[(2.0, 1.0), (4.0, 2.0)]),
                [false; 2],
                "{rule:?}"
            );
            assert_eq!(verdict(rule, true, &[(0.0, 0.0)]), [false], "{rule:?}");
        }
    }

    #[test]
    fn hysteresis_remembers() {
        let between = [(1.0, 0.4)];
        assert_eq!(verdict(Classifier::Hysteresis, true, &between), [true]);
        assert_eq!(verdict(Classifier::Hysteresis, false, &between), [false]);
    }
}
