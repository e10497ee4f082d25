//! What can be wrong with a scene, said with the place and the remedy.

/// A scene file, a parameter or an option that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Text that is not the JSON of a scene.
    #[error("{origin}:{line}:{column}: {}{message}", prefix(.path))]
    Json {
        /// Where the text came from: a file's path, usually.
        origin: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The JSON path: `bodies[3].shapes[0]`; empty at the root.
        path: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A definition that makes no sense.
    #[error("{place}: {message}")]
    Invalid {
        /// As in `bodies[3] "brick": shapes[0].radius`.
        place: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A file that cannot be read or written.
    #[error("{path}: {message}")]
    File {
        /// The file.
        path: String,
        /// What the system says.
        message: String,
    },
}

/// The result of reading or making a scene.
pub type Result<T> = std::result::Result<T, SceneError>;

impl SceneError {
    /// A definition that makes no sense, with its place.
    pub fn invalid(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), message: message.into() }
    }

    /// What the engine refused, its place prefixed with `outer`.
    pub fn from_engine(outer: &str, error: ishigaki::Error) -> Self {
        match error {
            ishigaki::Error::Invalid { place, message } => Self::invalid(join(outer, &place), message),
            other => Self::invalid(outer, other.to_string()),
        }
    }
}

fn prefix(path: &str) -> String {
    if path.is_empty() { String::new() } else { format!("{path}: ") }
}

/// `bodies[3] "brick"` and `shapes[0].radius` become `bodies[3] "brick": shapes[0].radius`.
fn join(outer: &str, inner: &str) -> String {
    match (outer.is_empty(), inner.is_empty()) {
        (true, _) => inner.to_string(),
        (_, true) => outer.to_string(),
        _ => format!("{outer}: {inner}"),
    }
}

/// The known name nearest to a wrong one, if it is near enough to be a slip of the pen.
pub(crate) fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = wrong.to_lowercase();
    let distance = |name: &str| strsim::damerau_levenshtein(&lower, &name.to_lowercase());
    let allowed = ((wrong.chars().count() + 1) / 3).max(1);
    known.into_iter().map(|name| (distance(name), name)).filter(|&(d, _)| d <= allowed).min().map(|(_, name)| name)
}

/// `unknown scene "towr"; did you mean "tower"? There are: arch, tower` — with the remedy, however it is known.
pub(crate) fn unknown<'a>(what: &str, wrong: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let guess = nearest(wrong, known.clone()).map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
    let all: Vec<&str> = known.into_iter().collect();
    let separator = if guess.is_empty() { ";" } else { "" };
    if all.is_empty() {
        format!("unknown {what} `{wrong}`; there are none")
    } else {
        format!("unknown {what} `{wrong}`{guess}{separator} there are: {}", all.join(", "))
    }
}

/// serde's `unknown field` and `unknown variant` messages with a guess put in.
pub(crate) fn with_guess(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    if !message.starts_with("unknown ") {
        return message.to_string();
    }
    let Some(wrong) = quoted.next() else { return message.to_string() };
    match nearest(wrong, quoted) {
        Some(name) => message.replacen(", expected", &format!(", did you mean `{name}`? Expected"), 1),
        None => message.to_string(),
    }
}
