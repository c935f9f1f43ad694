use super::*;
use crate::body::RigidBody;
use crate::graph::tests::Site;
use fastrand::Rng;

/// The bodies of an island, and the pairs of its contacts.
type Content = (Vec<Member>, Vec<Entity>);

impl Order {
    fn content(&self) -> Vec<Content> {
        let islands = (0..self.numbered.len()).map(|number| self.of(number));
        islands
            .map(|island| (island.bodies.clone(), island.pairs().collect()))
            .collect()
    }

    fn keep_for(&mut self, site: &Site) {
        self.keep(&site.table, &site.graph, &site.islands);
    }

    /// Compares the order with one that is computed from nothing.
    fn check(&self, site: &Site) {
        let mut anew = Order::default();
        anew.keep_for(site);
        assert_eq!(self.content(), anew.content());
        assert_eq!(self.local, anew.local);
        for (edge, (at, anew)) in self.by_edge.iter().zip(&anew.by_edge).enumerate() {
            assert_eq!((at.island, at.index), (anew.island, anew.index), "{edge}");
        }
        let starts = |order: &Order| {
            let ids = order.numbered.iter().map(|&id| &order.islands[id as usize]);
            ids.map(|island| (island.number, island.first))
                .collect::<Vec<_>>()
        };
        assert_eq!(starts(self), starts(&anew));
    }
}

#[test]
fn an_order_that_follows_changes_equals_one_computed_from_nothing() {
    for seed in 0..20 {
        let mut rng = Rng::with_seed(seed);
        let mut site = Site::default();
        let mut order = Order::default();
        for number in 0..8 {
            site.spawn(match number {
                0 => RigidBody::Static,
                _ => RigidBody::Dynamic,
            });
        }
        let mut has_content = false;
        for _ in 0..300 {
            for _ in 0..rng.u8(0..4) {
                site.edit(&mut rng);
            }
            site.update();
            order.keep_for(&site);
            order.check(&site);
            has_content |= !order.content().is_empty();
        }
        assert!(has_content);
    }
}

/// Two stacks of two bodies on a floor.
fn two_stacks() -> (Site, [u32; 5]) {
    let mut site = Site::default();
    let floor = site.spawn(RigidBody::Static);
    let [a, b, c, d] = [(); 4].map(|()| site.spawn(RigidBody::Dynamic));
    for slots in [[floor, a], [a, b], [floor, c], [c, d]] {
        site.connect(slots);
        site.link(slots, true);
    }
    site.update();
    (site, [floor, a, b, c, d])
}

#[test]
fn only_islands_that_changed_are_ordered_anew() {
    let (mut site, [_, a, b, c, d]) = two_stacks();
    let mut order = Order::default();
    order.keep_for(&site);
    let of =
        |order: &Order, site: &Site, slot: u32| order.of(site.islands.of(slot).unwrap()).revision;
    let before = [a, c].map(|slot| of(&order, &site, slot));
    site.link([c, d], false);
    site.update();
    order.keep_for(&site);
    let now = [a, c].map(|slot| of(&order, &site, slot));
    assert_eq!(now[0], before[0]);
    assert_ne!(now[1], before[1]);
    // Another island gets another number, and keeps its order.
    site.despawn(b);
    site.despawn(a);
    let before = of(&order, &site, c);
    site.update();
    order.keep_for(&site);
    assert_eq!(of(&order, &site, c), before);
    order.check(&site);
}

/// A body whose input is found to be invalid after *islands* is removed from the table before the solve.
#[test]
fn a_body_that_was_removed_since_the_islands_were_updated_is_not_ordered() {
    for removed in 0..2 {
        let (mut site, bodies) = two_stacks();
        let mut order = Order::default();
        order.keep_for(&site);
        let slot = bodies[removed];
        let entity = site.table.get(slot).unwrap().entity;
        site.table.remove(entity, crate::body::BodyIndex(slot));
        order.keep_for(&site);
        order.check(&site);
        let contents = order.content();
        let contacts: usize = contents.iter().map(|(_, pairs)| pairs.len()).sum();
        assert_eq!(contacts, 2);
        let members = contents.iter().flat_map(|(bodies, _)| bodies);
        assert!(members.into_iter().all(|member| member.entity != entity));
    }
}

/// A wall of 10 × 10 bricks on a floor, in which contacts begin and end: those with the course below, and those side by side.
#[test]
fn an_order_that_is_edited_equals_one_computed_from_nothing() {
    let mut site = Site::default();
    let floor = site.spawn(RigidBody::Static);
    let bricks: Vec<u32> = (0..100).map(|_| site.spawn(RigidBody::Dynamic)).collect();
    let mut edges = Vec::new();
    for (number, &brick) in bricks.iter().enumerate() {
        if number % 10 > 0 {
            edges.push([bricks[number - 1], brick]);
        }
        match number.checked_sub(10) {
            Some(below) => {
                edges.extend([[bricks[below], brick], [bricks[below - below % 10], brick]])
            }
            None => edges.push([floor, brick]),
        }
    }
    edges.sort_unstable();
    edges.dedup();
    for &slots in &edges {
        site.connect(slots);
        site.link(slots, true);
    }
    site.update();
    let mut order = Order::default();
    order.keep_for(&site);
    let mut rng = Rng::with_seed(1);
    for round in 0..300 {
        for _ in 0..rng.u8(1..3) {
            // An edge that ended gets a number that another edge had.
            let slots = edges[rng.usize(..edges.len())];
            match round % 4 {
                0 => site.link(slots, false),
                1 => {
                    site.disconnect(slots);
                    site.connect(slots);
                }
                _ => site.link(slots, true),
            }
        }
        site.update();
        order.keep_for(&site);
        order.check(&site);
    }
    assert!(order.edits > 50, "{}", order.edits);
}
