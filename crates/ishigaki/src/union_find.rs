//! Disjoint sets over indices, by parents.

/// The representative of a set; halves the path on the way.
pub(crate) fn root(parents: &mut [u32], mut i: u32) -> u32 {
    while parents[i as usize] != i {
        parents[i as usize] = parents[parents[i as usize] as usize];
        i = parents[i as usize];
    }
    i
}

/// Unites two sets; the smaller of their representatives, which do not depend on the order of unions, becomes that of
/// both.
pub(crate) fn unite(parents: &mut [u32], a: u32, b: u32) -> u32 {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
    a.min(b)
}
