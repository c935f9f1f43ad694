//! Finds the parts of a grid that are no longer joined to the rest.

use super::Voxels;
use super::grid::SIDES;
use bevy_platform::collections::{HashMap, HashSet};
use glam::IVec3;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// No more cells are visited after an edit: parts as large as that stay.
const MAX_VISITS: usize = 1 << 20;

/// Cells that were reached from the same neighbour of emptied cells, or from several that turned out to be joined.
struct Part {
    /// The part that it has become one with, or itself.
    joined: usize,
    /// Cells whose neighbours are still to be visited.
    edge: VecDeque<IVec3>,
}

fn root_of(parts: &mut [Part], mut part: usize) -> usize {
    while parts[part].joined != part {
        parts[part].joined = parts[parts[part].joined].joined;
        part = parts[part].joined;
    }
    part
}

/// The parts that are no longer joined to the largest one after cells were emptied, each as its cells. With a `ground`, those that have a
/// cell at or below it stay, and the others are detached.
///
/// Parts grow from the neighbours of the emptied cells, all at the same rate, and are one when they meet. Those that stop growing are
/// detached. The last one need not be visited to its end, so the work is proportional to what comes off.
pub(super) fn detached(
    voxels: &Voxels,
    emptied: &[[i32; 3]],
    ground: Option<i32>,
) -> Vec<Vec<IVec3>> {
    let mut seen: HashMap<IVec3, usize> = HashMap::default();
    let mut parts: Vec<Part> = Vec::new();
    for cell in emptied {
        for side in SIDES {
            let cell = IVec3::from_array(*cell) + side;
            if voxels.get(cell) && !seen.contains_key(&cell) {
                seen.insert(cell, parts.len());
                parts.push(Part {
                    joined: parts.len(),
                    edge: VecDeque::from([cell]),
                });
            }
        }
    }
    let mut growing: Vec<usize> = (0..parts.len()).collect();
    let mut loose: Vec<usize> = Vec::new();
    while growing.len() > 1 {
        if seen.len() > MAX_VISITS {
            break;
        }
        for number in std::mem::take(&mut growing) {
            let part = root_of(&mut parts, number);
            if part != number {
                continue;
            }
            let Some(cell) = parts[part].edge.pop_front() else {
                loose.push(part);
                continue;
            };
            for side in SIDES {
                let next = cell + side;
                let own = root_of(&mut parts, part);
                match seen.get(&next).copied() {
                    Some(other) => {
                        let other = root_of(&mut parts, other);
                        if other != own {
                            join(&mut parts, own, other);
                        }
                    }
                    None if voxels.get(next) => {
                        seen.insert(next, own);
                        parts[own].edge.push_back(next);
                    }
                    None => (),
                }
            }
            growing.push(root_of(&mut parts, part));
        }
        growing.sort_unstable();
        growing.dedup();
    }
    if let Some(ground) = ground
        && !loose.is_empty()
    {
        let rest = growing.first().copied();
        stand(voxels, ground, &mut seen, &mut parts, (&mut loose, rest));
    }
    if loose.is_empty() {
        return Vec::new();
    }
    sorted(&seen, &mut parts, &loose)
}

/// Leaves those out of the loose parts that stand on the ground. The `rest` is the largest part, but it may hang in the air: then it is
/// loose.
fn stand(
    voxels: &Voxels,
    ground: i32,
    seen: &mut HashMap<IVec3, usize>,
    parts: &mut [Part],
    (loose, rest): (&mut Vec<usize>, Option<usize>),
) {
    let held = |cell: &IVec3| cell.y <= ground;
    let standing = seen.iter().filter(|(cell, _)| held(cell));
    let standing: HashSet<usize> = standing.map(|(_, part)| *part).collect();
    let standing = standing.into_iter().map(|part| root_of(parts, part));
    let standing: Vec<usize> = standing.collect();
    loose.retain(|part| !standing.contains(part));
    let rest = rest.filter(|part| !standing.contains(part));
    if let Some(rest) = rest
        && let Some(cells) = hangs(voxels, &parts[rest].edge, held)
    {
        seen.extend(cells.into_iter().map(|cell| (cell, rest)));
        loose.push(rest);
    }
}

/// The cells of each of the loose parts, in order: hash maps have none.
fn sorted(seen: &HashMap<IVec3, usize>, parts: &mut [Part], loose: &[usize]) -> Vec<Vec<IVec3>> {
    let mut found: HashMap<usize, Vec<IVec3>> = HashMap::default();
    for (&cell, &part) in seen {
        let part = root_of(parts, part);
        if loose.contains(&part) {
            found.entry(part).or_default().push(cell);
        }
    }
    let mut found: Vec<Vec<IVec3>> = found.into_values().collect();
    for cells in &mut found {
        cells.sort_unstable_by_key(IVec3::to_array);
    }
    found.sort_unstable_by_key(|cells| cells[0].to_array());
    found
}

/// All cells that are joined to some, if none of them is held. The search goes down first, where the ground is.
fn hangs(
    voxels: &Voxels,
    from: &VecDeque<IVec3>,
    held: impl Fn(&IVec3) -> bool,
) -> Option<HashSet<IVec3>> {
    let mut seen: HashSet<IVec3> = from.iter().copied().collect();
    let key = |cell: IVec3| (Reverse(cell.y), cell.x, cell.z);
    let mut next: BinaryHeap<_> = from.iter().copied().map(key).collect();
    while let Some((Reverse(y), x, z)) = next.pop() {
        let cell = IVec3::new(x, y, z);
        if held(&cell) || seen.len() > MAX_VISITS {
            return None;
        }
        for side in SIDES {
            let beside = cell + side;
            if voxels.get(beside) && seen.insert(beside) {
                next.push(key(beside));
            }
        }
    }
    Some(seen)
}

/// Makes two parts one. The one that was met goes on growing.
fn join(parts: &mut [Part], one: usize, other: usize) {
    let edge = std::mem::take(&mut parts[one].edge);
    parts[other].edge.extend(edge);
    parts[one].joined = other;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts as a plain flood finds them, without the largest.
    fn flooded(voxels: &Voxels) -> Vec<Vec<IVec3>> {
        let mut left: Vec<IVec3> = voxels.cells().collect();
        let mut parts = Vec::new();
        while let Some(first) = left.pop() {
            let (mut part, mut edge) = (vec![first], vec![first]);
            while let Some(cell) = edge.pop() {
                for side in SIDES {
                    if let Some(at) = left.iter().position(|other| *other == cell + side) {
                        edge.push(left.swap_remove(at));
                        part.push(cell + side);
                    }
                }
            }
            part.sort_unstable_by_key(IVec3::to_array);
            parts.push(part);
        }
        parts.sort_unstable_by_key(|part| (part.len(), part[0].to_array()));
        parts.pop();
        parts
    }

    #[test]
    fn what_comes_off_is_what_a_flood_finds() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut all = 0;
        for _ in 0..200 {
            let mut voxels = Voxels::new(1.0);
            voxels.set_box(IVec3::splat(-3), IVec3::splat(3), true);
            let mut cell = || IVec3::from_array(std::array::from_fn(|_| random.i32(-3..3)));
            let emptied: Vec<_> = (0..120).map(|_| cell().to_array()).collect();
            for cell in &emptied {
                voxels.set(IVec3::from_array(*cell), false);
            }
            let mut found = detached(&voxels, &emptied, None);
            found.sort_unstable_by_key(|part| (part.len(), part[0].to_array()));
            let expected = flooded(&voxels);
            // Of two that are as large either may be left.
            let sizes = |parts: &[Vec<IVec3>]| parts.iter().map(Vec::len).collect::<Vec<_>>();
            assert_eq!(sizes(&found), sizes(&expected));
            all += found.len();
        }
        assert!(all > 200, "{all}");
    }

    /// A slab on a post: without a ground the slab stays, with one the post. What stands on two posts stays on one.
    #[test]
    fn what_stands_on_the_ground_stays() {
        let mut voxels = Voxels::new(1.0);
        voxels.set_box(IVec3::new(0, 0, 0), IVec3::new(1, 6, 1), true);
        voxels.set_box(IVec3::new(-5, 6, -5), IVec3::new(6, 7, 6), true);
        let cut = |voxels: &mut Voxels, cell: IVec3, ground| {
            voxels.set(cell, false);
            let parts = detached(voxels, &[cell.to_array()], ground);
            voxels.set(cell, true);
            parts.iter().map(Vec::len).collect::<Vec<_>>()
        };
        let post = IVec3::new(0, 3, 0);
        assert_eq!(cut(&mut voxels, post, None), [3]);
        assert_eq!(cut(&mut voxels, post, Some(0)), [2 + 121]);
        voxels.set_box(IVec3::new(4, 0, 4), IVec3::new(5, 6, 5), true);
        assert!(cut(&mut voxels, post, Some(0)).is_empty());
        assert!(cut(&mut voxels, IVec3::new(0, 0, 0), Some(0)).is_empty());
    }

    /// A cell from a large solid is no reason to visit all of it.
    #[test]
    fn a_cell_from_a_large_solid_costs_little() {
        let mut voxels = Voxels::new(1.0);
        voxels.set_box(IVec3::ZERO, IVec3::splat(64), true);
        let cell = IVec3::splat(30);
        voxels.set(cell, false);
        let start = std::time::Instant::now();
        assert!(detached(&voxels, &[cell.to_array()], None).is_empty());
        assert!(start.elapsed().as_millis() < 50);
    }
}
