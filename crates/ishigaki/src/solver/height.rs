//! Heights. TALK D5.
//!
//! The height of a body is the least number of hops over contacts to a fixed or kinematic body: breadth-first
//! search from the ground. Bodies that are not reached have none. Joints are not hops unless asked.
//! WA and shock propagation take "below" from it. Known pathology: where a plank lies on two towers of
//! different brick counts, a supporter can be higher than its load. Option: `solver.height`; shown by
//! `tests/techniques.rs`.

use crate::body::NO_HEIGHT;
use std::collections::VecDeque;

// ANCHOR: heights
/// Hops from the ground for each of `heights.len()` nodes; `ground` nodes have 0. Links go both ways.
///
/// Scratch arrays are the caller's, so that a settled world allocates nothing.
pub fn heights(
    links: impl Iterator<Item = [u32; 2]> + Clone,
    is_ground: impl Fn(u32) -> bool,
    scratch: &mut Scratch,
    heights: &mut [u32],
) {
    scratch.build(links, heights.len());
    scratch.queue.clear();
    for (node, height) in heights.iter_mut().enumerate() {
        *height = NO_HEIGHT;
        if is_ground(node as u32) {
            *height = 0;
            scratch.queue.push_back(node as u32);
        }
    }
    while let Some(node) = scratch.queue.pop_front() {
        let next = heights[node as usize] + 1;
        let (first, last) = (scratch.starts[node as usize], scratch.starts[node as usize + 1]);
        for &other in &scratch.neighbors[first as usize..last as usize] {
            if heights[other as usize] == NO_HEIGHT {
                heights[other as usize] = next;
                scratch.queue.push_back(other);
            }
        }
    }
}
// ANCHOR_END: heights

/// Adjacency in compressed rows, and the queue of the search.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    starts: Vec<u32>,
    fill: Vec<u32>,
    neighbors: Vec<u32>,
    queue: VecDeque<u32>,
}

impl Scratch {
    fn build(&mut self, links: impl Iterator<Item = [u32; 2]> + Clone, nodes: usize) {
        self.starts.clear();
        self.starts.resize(nodes + 1, 0);
        for [a, b] in links.clone() {
            self.starts[a as usize + 1] += 1;
            self.starts[b as usize + 1] += 1;
        }
        for i in 0..nodes {
            self.starts[i + 1] += self.starts[i];
        }
        self.fill.clear();
        self.fill.extend_from_slice(&self.starts[..nodes]);
        self.neighbors.clear();
        self.neighbors.resize(self.starts[nodes] as usize, 0);
        for [a, b] in links {
            for (from, to) in [(a, b), (b, a)] {
                self.neighbors[self.fill[from as usize] as usize] = to;
                self.fill[from as usize] += 1;
            }
        }
    }
}
