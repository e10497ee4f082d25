//! Numbers of the command line that must make sense.

/// Steps in one run: more would take months.
const MOST_STEPS: u64 = 1_000_000_000;

/// How many steps: at least one.
pub fn steps(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(steps) if (1..=MOST_STEPS).contains(&steps) => Ok(steps),
        _ => Err(format!("must be a whole number from 1 to {MOST_STEPS}")),
    }
}

/// `STEP:FILE`.
pub fn step_and_file(text: &str) -> Result<(u64, std::path::PathBuf), String> {
    match text.split_once(':') {
        Some((step, file)) if !file.is_empty() => Ok((steps(step).map_err(|e| format!("the step {e}"))?, file.into())),
        _ => Err("must be STEP:FILE, such as 30:step30.json".into()),
    }
}

/// Length of a step, s.
pub fn time_step(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        // A step of a second is already far beyond what contacts can bear; longer is a slip of the pen.
        Ok(dt) if dt.is_finite() && dt > 0.0 && dt <= 1.0 => Ok(dt),
        _ => Err("must be a number of seconds, more than 0 and at most 1, such as 0.0166667".into()),
    }
}

/// `path=value`.
pub fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
            Ok((key.trim().into(), value.trim().into()))
        }
        _ => Err("must be path=value, such as solver.substeps=8".into()),
    }
}

/// `key=number`.
pub fn parameter(text: &str) -> Result<(String, f64), String> {
    let message = "must be key=number, such as n=40";
    let (key, value) = assignment(text).map_err(|_| message)?;
    Ok((key, value.parse().map_err(|_| message)?))
}
