//! Which contacts stick, equation (10): λ_n > 0 and ‖λ_t‖ < μ λ_n.
//!
//! The paper judges each point for itself and calls that naive. Judged on the sums over a manifold a slab just below its
//! critical slope creeps 300 times less, since the share of one corner in the load says little about the body.

use crate::contact::{Anchor, Impulse};
use crate::settings::Classifier;
use glam::Vec3;

/// A solved sliding contact lies on the cone only up to rounding; sticking is below this share of it.
const AT_THE_CONE: f32 = 0.999;

/// Where hysteresis lets sticking begin, as a share of the cone.
const ENTER: f32 = 0.6;

/// Sets `sticking` of every anchor of one manifold from the impulses of the last solve.
pub fn classify(rule: Classifier, friction: f32, impulses: &[Impulse], anchors: &mut [Anchor]) {
    let holds = |normal: f32, tangential: Vec3, share: f32| {
        normal > 0.0 && tangential.length() < share * friction * normal
    };
    let point = |i: &Impulse| holds(i.normal, i.tangential, AT_THE_CONE);
    let normal = impulses.iter().map(|i| i.normal).sum();
    let tangential = impulses.iter().map(|i| i.tangential).sum();
    let sticking = match rule {
        Classifier::PerPoint => {
            for (anchor, impulse) in anchors.iter_mut().zip(impulses) {
                anchor.sticking = point(impulse);
            }
            return;
        }
        Classifier::Any => impulses.iter().any(point),
        Classifier::All => normal > 0.0 && impulses.iter().filter(|i| i.normal > 0.0).all(point),
        Classifier::Sum => holds(normal, tangential, AT_THE_CONE),
        Classifier::Hysteresis => {
            let share = if anchors.iter().any(|a| a.sticking) {
                AT_THE_CONE
            } else {
                ENTER
            };
            holds(normal, tangential, share)
        }
    };
    anchors
        .iter_mut()
        .for_each(|anchor| anchor.sticking = sticking);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(rule: Classifier, was: bool, impulses: &[(f32, f32)]) -> Vec<bool> {
        let impulses: Vec<Impulse> = impulses
            .iter()
            .map(|&(normal, t)| Impulse {
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
