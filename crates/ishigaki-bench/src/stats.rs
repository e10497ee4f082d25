//! Medians and spreads of turns.

/// The value below which a part of the values lies, between neighbors in proportion; `None` without values.
pub fn quantile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = part.clamp(0.0, 1.0) * (sorted.len().checked_sub(1)?) as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    Some(low + (high - low) * place.fract())
}

/// Median, 16th and 84th percentile: what one standard deviation either way would be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half are below.
    pub median: f64,
    /// 16 % are below.
    pub low: f64,
    /// 84 % are below.
    pub high: f64,
}

/// `None` without values.
pub fn spread(values: &[f64]) -> Option<Spread> {
    let at = |part| quantile(values, part);
    Some(Spread { median: at(0.5)?, low: at(0.16)?, high: at(0.84)? })
}

/// Turn by turn, one engine's time over another's, for the turns both took.
///
/// Both took a turn within a second or so: what slows the machine down for minutes slows both, and the ratio stays.
pub fn ratios(engine: &[f64], reference: &[f64]) -> Vec<f64> {
    engine.iter().zip(reference).map(|(e, r)| e / r).collect()
}

/// The power of x that y grows with: the slope of the line through (ln x, ln y) by least squares. `None` for fewer
/// than two different x, or what has no logarithm.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    if !points.iter().all(|&(x, y)| x > 0.0 && y > 0.0) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let square: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let product: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (square > 0.0).then(|| product / square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_is_that_of_a_power_law() {
        let law = |power: f64| -> Vec<(f64, f64)> { [1e3, 3e3, 1e4].map(|x: f64| (x, 7.0 * x.powf(power))).to_vec() };
        assert!((exponent(&law(0.0)).unwrap()).abs() < 1e-12);
        assert!((exponent(&law(1.0)).unwrap() - 1.0).abs() < 1e-12);
        assert!((exponent(&law(-0.5)).unwrap() + 0.5).abs() < 1e-12);
        assert_eq!(exponent(&[(10.0, 2.0)]), None);
        assert_eq!(exponent(&[(10.0, 2.0), (20.0, 0.0)]), None);
    }

    #[test]
    fn quantiles_lie_between_neighbors_in_proportion() {
        let values = [4.0, 1.0, 3.0, 2.0, 5.0];
        assert_eq!(quantile(&values, 0.5), Some(3.0));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 1.0), Some(5.0));
        assert_eq!(quantile(&values, 0.625), Some(3.5));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn a_slow_minute_for_both_leaves_the_ratio() {
        let machine = [1.0, 1.0, 1.7, 1.7, 1.0, 1.0];
        let engine: Vec<f64> = machine.iter().map(|m| 3.0 * m).collect();
        let reference: Vec<f64> = machine.iter().map(|m| 2.0 * m).collect();
        let ratio = spread(&ratios(&engine, &reference)).unwrap();
        assert!((ratio.median - 1.5).abs() < 1e-12 && (ratio.high - ratio.low).abs() < 1e-12);
    }

    #[test]
    fn ratios_stop_where_an_engine_dropped_out() {
        assert_eq!(ratios(&[2.0, 4.0], &[1.0, 1.0, 1.0]), [2.0, 4.0]);
    }
}
