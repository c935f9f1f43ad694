use super::*;

fn visits(blocks: u32, of: &[[u32; 2]]) -> Visits {
    Visits {
        of: of.to_vec(),
        blocks,
    }
}

#[test]
fn an_edge_stands_before_the_first_block_of_its_bodies() {
    // Two segments of five blocks.
    let visits = visits(5, &[[0, 0], [0, 2], [1, 4], [3, 6], [5, 9]]);
    let places = EdgePlaces::new(&[vec![3], vec![1, 2], vec![4]], &visits);
    let of: Vec<_> = places
        .groups()
        .iter()
        .map(|g| (g.block, g.segment, places.edges_of(g), places.bodies_of(g)))
        .collect();
    let expected: [(u32, u32, &[u32], &[u32]); 3] = [
        (0, 0, &[1], &[1, 2]),
        (0, 1, &[2], &[4]),
        (3, 0, &[0], &[3]),
    ];
    assert_eq!(of, expected);
    assert!(places.fits_segments);
    assert_eq!(places.before(0).len(), 2);
    assert_eq!(places.before(1).len(), 0);
    assert_eq!(places.before(3).len(), 1);
}

#[test]
fn edges_that_share_a_body_keep_their_order_in_one_group() {
    let visits = visits(5, &[[0, 0], [0, 2], [1, 4], [3, 6], [5, 9]]);
    // The last edge joins the first two.
    let places = EdgePlaces::new(&[vec![3], vec![1], vec![4], vec![1, 3]], &visits);
    let [one, other] = places.groups() else {
        panic!("{places:?}");
    };
    assert_eq!(places.edges_of(other), [0, 1, 3]);
    assert_eq!(places.bodies_of(other), [1, 3]);
    assert_eq!((other.block, other.segment), (0, 0));
    assert_eq!((one.block, one.segment), (0, 1));
    // The visits go from 0 to 6, but the next segment would come after 5.
    assert!(!places.fits_segments);
}
