//! Sparse LDLᵀ of a symmetric positive matrix of small blocks: the direct solver behind level correction and joint
//! trees.
//!
//! The graph of blocks is eliminated by least degree (ties by index): a tower, a chain and a tree fill in nothing,
//! and their cost is linear. What a factorization would cost is known before it is made, so that callers can choose
//! a coarser system. A pivot that vanishes against its own diagonal (two modes that say the same) is left out.
//! The order depends on the graph alone: same input, same bits.
//! Source: George & Liu, *Computer Solution of Large Sparse Positive Definite Systems* (1981), chapters 2 and 5.
#![expect(clippy::needless_range_loop, reason = "kernels walk several arrays of rows in step")]

/// Rows of a block at most.
pub const MAX_SIZE: usize = 6;
/// A dense block, row by row.
pub type Block = [[f32; MAX_SIZE]; MAX_SIZE];
/// A pivot below this part of its diagonal is rounding.
const TINY_PIVOT: f32 = 1e-6;

/// Order of elimination and pattern of the factor; a function of the graph alone.
#[derive(Clone, Debug, Default)]
pub struct Pattern {
    /// Nodes in the order of elimination.
    order: Vec<u32>,
    /// Place of each node in `order`.
    place: Vec<u32>,
    /// Where the column of each place begins in `rows`.
    starts: Vec<u32>,
    /// Later places that the column of a place reaches, ascending.
    rows: Vec<u32>,
    /// Multiply-adds of a factorization of full blocks of `MAX_SIZE`, in units of MAX_SIZE³.
    cost: u64,
    /// Rows of each node.
    sizes: Vec<u8>,
    /// Rows of blocks that are looked at.
    width: usize,
    neighbors: Vec<Vec<u32>>,
}

impl Pattern {
    /// Finds an order for `nodes` nodes with these links; `false` when the factorization would cost more than
    /// `most_cost` block products.
    pub fn analyze(&mut self, nodes: usize, links: impl Iterator<Item = (u32, u32)>, most_cost: u64) -> bool {
        self.connect(nodes, links);
        self.order.clear();
        self.place.clear();
        self.place.resize(nodes, u32::MAX);
        self.starts.clear();
        self.starts.push(0);
        self.rows.clear();
        self.cost = 0;
        // Buckets of nodes by degree; entries may be stale, the degree now decides.
        let mut buckets: Vec<Vec<u32>> = Vec::new();
        for node in (0..nodes as u32).rev() {
            put(&mut buckets, self.neighbors[node as usize].len(), node);
        }
        let mut least = 0;
        while self.order.len() < nodes {
            while least < buckets.len() && buckets[least].is_empty() {
                least += 1;
            }
            let Some(node) = buckets.get_mut(least).and_then(Vec::pop) else { break };
            if self.place[node as usize] != u32::MAX || self.neighbors[node as usize].len() != least {
                continue;
            }
            self.place[node as usize] = self.order.len() as u32;
            self.order.push(node);
            let column = std::mem::take(&mut self.neighbors[node as usize]);
            let degree = column.len() as u64;
            self.cost += 1 + degree + degree * (degree + 1) / 2;
            if self.cost > most_cost {
                return false;
            }
            for &one in &column {
                let list = &mut self.neighbors[one as usize];
                list.retain(|&n| n != node);
                merge(list, &column, one);
                let degree = list.len();
                put(&mut buckets, degree, one);
                least = least.min(degree);
            }
            self.rows.extend(&column);
            self.starts.push(self.rows.len() as u32);
        }
        for k in 0..nodes {
            let column = &mut self.rows[self.starts[k] as usize..self.starts[k + 1] as usize];
            for row in column.iter_mut() {
                *row = self.place[*row as usize];
            }
            column.sort_unstable();
        }
        true
    }

    fn connect(&mut self, nodes: usize, links: impl Iterator<Item = (u32, u32)>) {
        for list in &mut self.neighbors {
            list.clear();
        }
        self.neighbors.resize(nodes.max(self.neighbors.len()), Vec::new());
        for (a, b) in links {
            if a != b {
                self.neighbors[a as usize].push(b);
                self.neighbors[b as usize].push(a);
            }
        }
        for list in &mut self.neighbors[..nodes] {
            list.sort_unstable();
            list.dedup();
        }
    }

    /// Says how many rows each node has; the others of its block stay empty. Comes before all else.
    pub fn set_sizes(&mut self, sizes: impl Iterator<Item = usize>) {
        self.sizes.clear();
        self.sizes.extend(sizes.map(|s| s as u8));
        self.width = if self.sizes.iter().any(|&size| size > 3) { MAX_SIZE } else { 3 };
    }

    fn size(&self, place: usize) -> u64 {
        u64::from(self.sizes[self.order[place] as usize])
    }

    /// Multiply-adds of a factorization.
    pub fn factor_work(&self) -> u64 {
        let column = |k: usize| {
            let (own, mut sum, mut before) = (self.size(k), 0, 0);
            for &row in &self.rows[self.column(k)] {
                let size = self.size(row as usize);
                before += size;
                sum += size * own * own + size * before * own;
            }
            sum + own * own * own / 3
        };
        (0..self.nodes()).map(column).sum()
    }

    /// Multiply-adds of a solution with the factors.
    pub fn solve_work(&self) -> u64 {
        let column = |k: usize| {
            let own = self.size(k);
            own * own + 2 * own * self.rows[self.column(k)].iter().map(|&r| self.size(r as usize)).sum::<u64>()
        };
        (0..self.nodes()).map(column).sum()
    }

    /// Nodes.
    pub fn nodes(&self) -> usize {
        self.order.len()
    }

    /// Products of blocks in a factorization.
    pub fn cost(&self) -> u64 {
        self.cost
    }

    /// Blocks below the diagonal.
    pub fn fill(&self) -> usize {
        self.rows.len()
    }

    fn column(&self, place: usize) -> std::ops::Range<usize> {
        self.starts[place] as usize..self.starts[place + 1] as usize
    }

    fn find(&self, column: usize, row: u32) -> usize {
        let range = self.column(column);
        range.start + self.rows[range].partition_point(|&r| r < row)
    }
}

fn put(buckets: &mut Vec<Vec<u32>>, degree: usize, node: u32) {
    if buckets.len() <= degree {
        buckets.resize(degree + 1, Vec::new());
    }
    buckets[degree].push(node);
}

/// Adds what `other` has and `list` lacks, except `own`; both ascend.
fn merge(list: &mut Vec<u32>, other: &[u32], own: u32) {
    for &n in other.iter().filter(|&&n| n != own) {
        if let Err(at) = list.binary_search(&n) {
            list.insert(at, n);
        }
    }
}

/// The matrix, then its factors.
#[derive(Clone, Debug, Default)]
pub struct BlockLdl {
    /// Of each place: the diagonal block; unit lower triangle after factoring.
    diagonal: Vec<Block>,
    /// 1/D of each place; 0 for rows left out.
    inverse_pivots: Vec<[f32; MAX_SIZE]>,
    /// Of each place: what pivots must exceed.
    least_pivots: Vec<[f32; MAX_SIZE]>,
    /// Blocks below the diagonal, by column: A, then L.
    below: Vec<Block>,
    /// What a block was before it was divided by its pivots.
    undivided: Vec<Block>,
}

/// In a browser a program must first get there: one kernel for all sizes takes half of the room.
const ONE_FOR_ALL: bool = cfg!(target_arch = "wasm32");

/// Points, and levels of a stack, have three rows: an eighth of what six take.
macro_rules! by_width {
    ($pattern:expr, $n:ident => $call:expr) => {
        if $pattern.width > 3 || ONE_FOR_ALL {
            const $n: usize = MAX_SIZE;
            $call
        } else {
            const $n: usize = 3;
            $call
        }
    };
}

impl BlockLdl {
    /// The zero matrix on a pattern.
    pub fn clear(&mut self, pattern: &Pattern) {
        self.diagonal.clear();
        self.diagonal.resize(pattern.nodes(), [[0.0; MAX_SIZE]; MAX_SIZE]);
        self.below.clear();
        self.below.resize(pattern.fill(), [[0.0; MAX_SIZE]; MAX_SIZE]);
    }

    /// The block (a, b) of the matrix, a and b nodes; transposed where b is eliminated later.
    pub fn add(&mut self, pattern: &Pattern, a: u32, b: u32, block: &Block) {
        let (pa, pb) = (pattern.place[a as usize], pattern.place[b as usize]);
        let (target, transposed) = match pa.cmp(&pb) {
            std::cmp::Ordering::Equal => (&mut self.diagonal[pa as usize], false),
            std::cmp::Ordering::Greater => (&mut self.below[pattern.find(pb as usize, pa)], false),
            std::cmp::Ordering::Less => (&mut self.below[pattern.find(pa as usize, pb)], true),
        };
        by_width!(pattern, N => add_block::<N>(target, block, transposed));
    }

    /// Adds `epsilon` times itself to the diagonal and factors.
    pub fn factor(&mut self, pattern: &Pattern, epsilon: f32) {
        self.raise_diagonal(pattern, epsilon);
        self.inverse_pivots.clear();
        self.inverse_pivots.resize(pattern.nodes(), [0.0; MAX_SIZE]);
        by_width!(pattern, N => self.eliminate::<N>(pattern));
    }

    fn raise_diagonal(&mut self, pattern: &Pattern, epsilon: f32) {
        self.least_pivots.clear();
        for block in &mut self.diagonal {
            let mut least = [0.0; MAX_SIZE];
            for (i, least) in least[..pattern.width].iter_mut().enumerate() {
                *least = TINY_PIVOT * block[i][i];
                block[i][i] += epsilon * block[i][i];
            }
            self.least_pivots.push(least);
        }
    }

    fn eliminate<const N: usize>(&mut self, pattern: &Pattern) {
        for k in 0..pattern.nodes() {
            self.inverse_pivots[k] = factor_diagonal::<N>(&mut self.diagonal[k], &self.least_pivots[k]);
            let range = pattern.column(k);
            self.undivided.clear();
            for block in &mut self.below[range.clone()] {
                let undivided = solve_rows::<N>(block, &self.diagonal[k], &self.inverse_pivots[k]);
                self.undivided.push(undivided);
            }
            for j in range.clone() {
                let column = pattern.rows[j] as usize;
                let factor = self.below[j];
                subtract_product::<N>(&mut self.diagonal[column], &self.undivided[j - range.start], &factor);
                let mut at = pattern.column(column).start;
                for i in j + 1..range.end {
                    while pattern.rows[at] != pattern.rows[i] {
                        at += 1;
                    }
                    subtract_product::<N>(&mut self.below[at], &self.undivided[i - range.start], &factor);
                }
            }
        }
    }

    /// x = A⁻¹ x; `x` by node.
    pub fn solve(&self, pattern: &Pattern, x: &mut [[f32; MAX_SIZE]]) {
        by_width!(pattern, N => self.substitute::<N>(pattern, x));
    }

    #[inline(never)]
    fn substitute<const N: usize>(&self, pattern: &Pattern, x: &mut [[f32; MAX_SIZE]]) {
        for k in 0..pattern.nodes() {
            let node = pattern.order[k] as usize;
            let mut own = x[node];
            forward::<N>(&self.diagonal[k], &mut own);
            x[node] = own;
            for at in pattern.column(k) {
                let later = &mut x[pattern.order[pattern.rows[at] as usize] as usize];
                for i in 0..N {
                    later[i] -= dot::<N>(&self.below[at][i], &own);
                }
            }
        }
        for k in (0..pattern.nodes()).rev() {
            let node = pattern.order[k] as usize;
            let mut own = x[node];
            for i in 0..N {
                own[i] *= self.inverse_pivots[k][i];
            }
            for at in pattern.column(k) {
                let later = &x[pattern.order[pattern.rows[at] as usize] as usize];
                for i in 0..N {
                    for j in 0..N {
                        own[j] -= self.below[at][i][j] * later[i];
                    }
                }
            }
            backward::<N>(&self.diagonal[k], &self.inverse_pivots[k], &mut own);
            x[node] = own;
        }
    }
}

// Small and hot. Kernels of a block stand for themselves, and what they call is inlined into them: left to the compiler, an edit
// far away costs a quarter of a factor.

#[inline(always)]
fn add_block<const N: usize>(sum: &mut Block, block: &Block, transposed: bool) {
    for i in 0..N {
        for j in 0..N {
            sum[i][j] += if transposed { block[j][i] } else { block[i][j] };
        }
    }
}

#[inline(always)]
fn dot<const N: usize>(a: &[f32; MAX_SIZE], b: &[f32; MAX_SIZE]) -> f32 {
    a[..N].iter().zip(&b[..N]).map(|(x, y)| x * y).sum()
}

/// A = L D Lᵀ in place (unit lower triangle below the diagonal); gives 1/D.
#[inline(never)]
fn factor_diagonal<const N: usize>(block: &mut Block, least: &[f32; MAX_SIZE]) -> [f32; MAX_SIZE] {
    let (mut pivots, mut inverse) = ([0.0_f32; MAX_SIZE], [0.0_f32; MAX_SIZE]);
    for i in 0..N {
        for j in 0..=i {
            let mut sum = block[i][j];
            for (k, pivot) in pivots.iter().enumerate().take(j) {
                sum -= block[i][k] * pivot * block[j][k];
            }
            if i == j {
                let usable = sum > least[i];
                pivots[i] = if usable { sum } else { 0.0 };
                inverse[i] = if usable { 1.0 / sum } else { 0.0 };
            } else {
                block[i][j] = sum * inverse[j];
            }
        }
    }
    inverse
}

/// B ← B L⁻ᵀ D⁻¹ for the factors of the diagonal; gives B L⁻ᵀ.
#[inline(never)]
fn solve_rows<const N: usize>(block: &mut Block, lower: &Block, inverse_pivots: &[f32; MAX_SIZE]) -> Block {
    let mut undivided = *block;
    for i in 0..N {
        forward::<N>(lower, &mut undivided[i]);
        for j in 0..N {
            block[i][j] = undivided[i][j] * inverse_pivots[j];
        }
    }
    undivided
}

/// C −= A Bᵀ.
#[inline(never)]
fn subtract_product<const N: usize>(c: &mut Block, a: &Block, b: &Block) {
    for i in 0..N {
        for j in 0..N {
            c[i][j] -= dot::<N>(&a[i], &b[j]);
        }
    }
}

/// x ← L⁻¹ x.
#[inline(always)]
fn forward<const N: usize>(lower: &Block, x: &mut [f32; MAX_SIZE]) {
    for i in 1..N {
        let sum: f32 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] -= sum;
    }
}

/// x ← L⁻ᵀ x; rows that are left out get nothing.
#[inline(always)]
fn backward<const N: usize>(lower: &Block, inverse_pivots: &[f32; MAX_SIZE], x: &mut [f32; MAX_SIZE]) {
    for i in (0..N).rev() {
        let sum: f32 = (i + 1..N).map(|k| lower[k][i] * x[k]).sum();
        x[i] = if inverse_pivots[i] == 0.0 { 0.0 } else { x[i] - sum };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::permutation::Random;

    fn random(r: &mut Random) -> f32 {
        r.below(2001) as f32 / 1000.0 - 1.0
    }

    /// A = Σ over links of JᵀJ-like blocks of `size` rows, positive definite by construction.
    fn check(size: usize, nodes: usize, links: &[(u32, u32)]) {
        let mut r = Random(7);
        let mut pattern = Pattern::default();
        pattern.set_sizes((0..nodes).map(|_| size));
        assert!(pattern.analyze(nodes, links.iter().copied(), u64::MAX));
        let mut ldl = BlockLdl::default();
        ldl.clear(&pattern);
        let n = nodes * MAX_SIZE;
        let mut dense = vec![vec![0.0_f64; n]; n];
        let mut put = |ldl: &mut BlockLdl, a: u32, b: u32, block: &Block| {
            ldl.add(&pattern, a, b, block);
            for i in 0..MAX_SIZE {
                for j in 0..MAX_SIZE {
                    dense[a as usize * MAX_SIZE + i][b as usize * MAX_SIZE + j] += f64::from(block[i][j]);
                    if a != b {
                        dense[b as usize * MAX_SIZE + j][a as usize * MAX_SIZE + i] += f64::from(block[i][j]);
                    }
                }
            }
        };
        let product = |x: &Block, y: &Block| -> Block {
            std::array::from_fn(|i| std::array::from_fn(|j| dot::<MAX_SIZE>(&x[i], &y[j])))
        };
        for &(a, b) in links {
            let mut block = || -> Block {
                let within = |i: usize, value: f32| if i < size { value } else { 0.0 };
                std::array::from_fn(|i| std::array::from_fn(|j| within(i.max(j), random(&mut r))))
            };
            let (x, y) = (block(), block());
            put(&mut ldl, a, a, &product(&x, &x));
            put(&mut ldl, b, b, &product(&y, &y));
            put(&mut ldl, a, b, &product(&x, &y));
        }
        let one: Block = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        for k in 0..nodes as u32 {
            put(&mut ldl, k, k, &one);
        }
        let mut one = |i: usize| if i < size { random(&mut r) } else { 0.0 };
        let wanted: Vec<[f32; MAX_SIZE]> = (0..nodes).map(|_| std::array::from_fn(&mut one)).collect();
        let mut x: Vec<[f32; MAX_SIZE]> = (0..nodes)
            .map(|node| {
                std::array::from_fn(|i| {
                    let row = &dense[node * MAX_SIZE + i];
                    row.iter().zip(wanted.iter().flatten()).map(|(a, b)| a * f64::from(*b)).sum::<f64>() as f32
                })
            })
            .collect();
        ldl.factor(&pattern, 0.0);
        ldl.solve(&pattern, &mut x);
        for (a, b) in x.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((a - b).abs() < 2e-4, "{a} instead of {b}");
        }
    }

    #[test]
    fn a_chain_a_tree_and_a_grid_are_solved() {
        for size in [1, 2, 3, 5, 6] {
            check(size, 12, &(0..11).map(|i| (i, i + 1)).collect::<Vec<_>>());
            check(size, 15, &(1..15).map(|i| ((i - 1) / 2, i)).collect::<Vec<_>>());
        }
        let grid = |x: u32, y: u32| x + 5 * y;
        let mut links = Vec::new();
        for y in 0..5 {
            for x in 0..4 {
                links.push((grid(x, y), grid(x + 1, y)));
                links.push((grid(y, x), grid(y, x + 1)));
            }
        }
        check(3, 25, &links);
        check(6, 25, &links);
    }

    #[test]
    fn chains_and_trees_fill_in_nothing() {
        let mut pattern = Pattern::default();
        assert!(pattern.analyze(100, (0..99).map(|i| (i + 1, i)), u64::MAX));
        assert_eq!(pattern.fill(), 99);
        assert!(pattern.analyze(127, (1..127).map(|i| ((i - 1) / 2, i)), u64::MAX));
        assert_eq!(pattern.fill(), 126);
        assert!(!pattern.analyze(40, (0..40).flat_map(|i| (0..i).map(move |j| (i, j))), 1000), "too dear");
    }

    #[test]
    fn a_mode_without_mass_gets_nothing() {
        let mut pattern = Pattern::default();
        pattern.set_sizes([MAX_SIZE].into_iter());
        assert!(pattern.analyze(1, std::iter::empty(), u64::MAX));
        let mut ldl = BlockLdl::default();
        ldl.clear(&pattern);
        let mut block = [[0.0; MAX_SIZE]; MAX_SIZE];
        block[2][2] = 4.0;
        ldl.add(&pattern, 0, 0, &block);
        ldl.factor(&pattern, 0.0);
        let mut x = [[8.0; MAX_SIZE]];
        ldl.solve(&pattern, &mut x);
        assert_eq!(x[0], [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
    }
}
