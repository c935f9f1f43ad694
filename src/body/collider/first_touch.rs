//! The first place on a straight way where a convex shape touches another one.

use glam::Vec3;
use parry3d::query::{Contact, Unsupported};

/// How a shape on a straight way comes to another one.
pub(crate) enum Approach {
    /// They do not touch.
    Passes,
    /// They touch after `way`, m. `touch` holds the closest points there, and `closing` by how much the distance falls per length of the
    /// way.
    Touches {
        way: f32,
        touch: Contact,
        closing: f32,
    },
    /// Parry knows no closest points somewhere on the way.
    Lost,
}

/// Shapes that are no farther apart touch, m.
pub(crate) const TOUCHING_DISTANCE: f32 = 1e-5;

/// Finds the first place on a way where a convex shape touches another one, if it does within `longest`, m. `at` returns the closest points
/// of the two after some way (m) along the unit vector `direction`, with normals out of the other one.
///
/// This is Newton's method for the distance of the two. On a straight way it is a convex function of the place, and the normal of the
/// closest points is its slope, so no step goes too far, and shapes that do not come closer never meet. (Parry's cast searches in the
/// Minkowski difference. Where shapes pass at some millimetres, it finds hits that are none, and it misses some at grazing angles.)
///
/// # Errors
/// Those of `at`.
pub(crate) fn first_touch(
    direction: Vec3,
    longest: f32,
    at: impl Fn(f32) -> Result<Option<Contact>, Unsupported>,
) -> Result<Approach, Unsupported> {
    /// By how much the cosine of a normal may be wrong: parry stops when it knows the distance to a thousandth.
    const COSINE_ERROR: f32 = 0.05;
    /// Below this distance the doubt is not worth further steps, m.
    const NEAR_DISTANCE: f32 = 2e-3;
    /// Most hits need five steps. Past a surface at a tenth of a millimetre there would be very many.
    const MAX_STEPS: u32 = 60;
    /// Parry fails for some shapes that nearly touch, or finds them deeper than they can be. Then shorter steps are taken, down to this
    /// share.
    const MIN_STEP_SHARE: f32 = 1e-3;
    let Some(mut touch) = at(0.0)? else {
        return Ok(Approach::Lost);
    };
    let (mut way, mut closing) = (0.0, 1.0);
    let mut shorter = 1.0;
    for step in 0..MAX_STEPS {
        if touch.dist <= TOUCHING_DISTANCE {
            break;
        }
        let doubt = match touch.dist < NEAR_DISTANCE || step > MAX_STEPS / 2 {
            true => 0.0,
            false => COSINE_ERROR,
        };
        closing = doubt - direction.dot(touch.normal1);
        if closing <= 0.0 || closing * (longest - way) < touch.dist {
            return Ok(Approach::Passes);
        }
        let on = shorter * touch.dist / closing;
        match at(way + on)? {
            Some(next) if next.dist > touch.dist - on - NEAR_DISTANCE => {
                (touch, way, shorter) = (next, way + on, 1.0);
            }
            _ if on < TOUCHING_DISTANCE => break,
            _ if shorter < MIN_STEP_SHARE && touch.dist > NEAR_DISTANCE => {
                return Ok(Approach::Lost);
            }
            _ => shorter *= 0.5,
        }
    }
    Ok(Approach::Touches {
        way,
        touch,
        closing,
    })
}
