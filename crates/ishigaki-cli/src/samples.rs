//! Timings of many steps in bounded memory.

/// As many samples are kept at most.
const CAPACITY: usize = 1 << 20;

/// Samples of a quantity: every one at first, then every second, every fourth … of a very long run.
pub struct Samples {
    kept: Vec<f64>,
    every: u64,
    seen: u64,
    max: f64,
}

impl Samples {
    pub fn new() -> Self {
        Self { kept: Vec::new(), every: 1, seen: 0, max: 0.0 }
    }

    pub fn push(&mut self, value: f64) {
        if self.seen.is_multiple_of(self.every) {
            if self.kept.len() == CAPACITY {
                let mut index = 0;
                self.kept.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                self.kept.push(value);
            }
        }
        self.seen += 1;
        self.max = self.max.max(value);
    }

    /// The smallest sample that a part `q` of all samples does not exceed; 0 without samples.
    pub fn quantile(&self, q: f64) -> f64 {
        let mut sorted = self.kept.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (q * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
    }

    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    pub fn max(&self) -> f64 {
        self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_samples_by_rank() {
        let mut samples = Samples::new();
        (1..=100).rev().for_each(|i| samples.push(f64::from(i)));
        assert_eq!((samples.median(), samples.quantile(0.95), samples.max()), (50.0, 95.0, 100.0));
        assert_eq!(Samples::new().median(), 0.0);
    }

    #[test]
    fn a_long_run_keeps_evenly_spaced_samples() {
        let mut samples = Samples::new();
        let count = 2 * CAPACITY as u64 + 10;
        (0..count).for_each(|i| samples.push(i as f64));
        assert!(samples.kept.len() <= CAPACITY);
        assert!(samples.kept.windows(2).all(|w| w[1] - w[0] == samples.every as f64));
        let middle = count as f64 / 2.0;
        assert!((samples.median() - middle).abs() <= 4.0, "{} is not near {middle}", samples.median());
        assert_eq!(samples.max(), (count - 1) as f64);
    }
}
