//! Frictional contact problems as others write them down: u = W r + q with Coulomb's law at every contact. TALK C2.
//!
//! The text format of the Siconos project and its collection FCLIB: dimension, number of contacts, storage kind, a matrix of
//! 3×3 blocks, q, μ. In each contact the normal comes first. Coulomb with De Saxcé's term: r ∈ K = {|r_t| ≤ μ r_n},
//! û = u + μ|u_t| n ∈ K*, r·û = 0; the error of r is that of the natural map, ‖r − P_K(r − û)‖ / max(‖q‖, ‖r‖, ‖u‖).
//! Blocks are kept sparse: real files have thousands of contacts. The methods are in `coulomb.rs`.

use crate::error::{Error, Result};
use glam::{DMat3, DVec3};

/// A frictional contact problem in three dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionContact {
    /// For each contact the contacts that it sees, with their blocks.
    pub(crate) blocks: Vec<Vec<(usize, DMat3)>>,
    /// Its own block.
    pub(crate) diagonal: Vec<DMat3>,
    pub(crate) q: Vec<DVec3>,
    pub(crate) mu: Vec<f64>,
}

impl FrictionContact {
    /// Reads the text format.
    ///
    /// ```
    /// use ishigaki::lcp::{FrictionContact, Settings};
    /// // One contact of 1 kg, pressed by 1 N·s and pushed aside by 2 N·s, μ = 1/2.
    /// let header = "3\n 1\n 1\n 3 3\n 1\n 1 1\n 3\n 3\n 2\n 1\n 0 1\n 0\n";
    /// let problem = FrictionContact::parse(&format!("{header} 0\n 1 0 0 0 1 0 0 0 1\n -1 -2 0\n 0.5\n"))?;
    /// let solution = problem.solve_blocks(&Settings::default());
    /// assert!((solution.reaction[0][0] - 1.0).abs() < 1e-12);
    /// assert!((solution.reaction[0][1] - 0.5).abs() < 1e-12);
    /// # Ok::<(), ishigaki::Error>(())
    /// ```
    ///
    /// # Errors
    /// Anything but dimension 3 and block-sparse storage, sizes that do not fit, numbers that are none; with the line.
    pub fn parse(text: &str) -> Result<Self> {
        let mut words = Words::new(text);
        words.exactly("the dimension", 3)?;
        let contacts = words.index("the number of contacts")?;
        words.exactly("the storage kind (1: 3×3 blocks)", 1)?;
        for what in ["the number of rows", "the number of columns"] {
            words.exactly(what, 3 * contacts)?;
        }
        let count = words.index("the number of blocks")?;
        for what in ["the number of rows of blocks", "the number of columns of blocks"] {
            words.exactly(what, contacts)?;
        }
        for _ in 0..2 {
            for contact in 1..=contacts {
                words.exactly("the end of a block", 3 * contact)?;
            }
        }
        words.exactly("the number of row starts", contacts + 1)?;
        words.exactly("the number of column indices", count)?;
        let starts = words.starts(contacts, count)?;
        let columns = words.columns(contacts, count)?;

        let mut problem = Self {
            blocks: vec![Vec::new(); contacts],
            diagonal: vec![DMat3::ZERO; contacts],
            q: Vec::new(),
            mu: Vec::new(),
        };
        for row in 0..contacts {
            for (k, &column) in columns.iter().enumerate().take(starts[row + 1]).skip(starts[row]) {
                words.exactly("the index of a block", k)?;
                let block = words.block()?;
                problem.blocks[row].push((column, block));
                if column == row {
                    problem.diagonal[row] = block;
                }
            }
            // No impulse could open or close it.
            if problem.diagonal[row].x_axis.x <= 0.0 {
                return Err(
                    words.wrong(&format!("contact {row} has no mass along its normal: W[{row}][{row}][0][0] ≤ 0"))
                );
            }
        }
        for _ in 0..contacts {
            problem.q.push(words.vector("q")?);
        }
        for _ in 0..contacts {
            let mu = words.number("μ")?;
            if mu < 0.0 {
                return Err(words.wrong(&format!("μ must be ≥ 0, is {mu}")));
            }
            problem.mu.push(mu);
        }
        words.end()?;
        Ok(problem)
    }

    /// How many contacts.
    pub fn len(&self) -> usize {
        self.q.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.q.is_empty()
    }

    /// u of one contact.
    pub(crate) fn velocity_of(&self, contact: usize, reaction: &[DVec3]) -> DVec3 {
        self.blocks[contact].iter().fold(self.q[contact], |u, (other, block)| u + *block * reaction[*other])
    }

    /// u = W r + q.
    pub(crate) fn velocity(&self, reaction: &[DVec3]) -> Vec<DVec3> {
        (0..self.len()).map(|i| self.velocity_of(i, reaction)).collect()
    }

    /// ‖r − P_K(r − (u + μ|u_t| n))‖ / max(‖q‖, ‖r‖, ‖u‖); 0 where all of these are 0.
    pub(crate) fn error(&self, reaction: &[DVec3], velocity: &[DVec3]) -> f64 {
        let norm = |v: &[DVec3]| v.iter().map(|x| x.length_squared()).sum::<f64>().sqrt();
        let mut square = 0.0;
        for ((r, u), &mu) in reaction.iter().zip(velocity).zip(&self.mu) {
            let sliding = (u.y * u.y + u.z * u.z).sqrt();
            square += (*r - onto_cone(*r - *u - DVec3::new(mu * sliding, 0.0, 0.0), mu)).length_squared();
        }
        let scale = norm(&self.q).max(norm(reaction)).max(norm(velocity));
        if scale > 0.0 { square.sqrt() / scale } else { 0.0 }
    }
}

/// The nearest point of the cone |x_t| ≤ μ x_n.
pub(crate) fn onto_cone(x: DVec3, mu: f64) -> DVec3 {
    let tangent = (x.y * x.y + x.z * x.z).sqrt();
    if tangent <= mu * x.x {
        return x;
    }
    // On the edge (1, μ), as far along it as x reaches; below the polar cone, the tip.
    let along = (x.x + mu * tangent) / (1.0 + mu * mu);
    if along <= 0.0 {
        return DVec3::ZERO;
    }
    let scale = if tangent > 0.0 { mu * along / tangent } else { 0.0 };
    DVec3::new(along, scale * x.y, scale * x.z)
}

/// The words of a text and the line of the last one.
struct Words<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    line: usize,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        let words = (1..).zip(text.lines()).flat_map(|(n, line)| line.split_whitespace().map(move |word| (n, word)));
        Self { words: Box::new(words), line: 1 }
    }

    fn wrong(&self, message: &str) -> Error {
        Error::invalid(format!("line {}", self.line), message)
    }

    fn word(&mut self, what: &str) -> Result<&'a str> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.wrong(&format!("the file ends where {what} should be")));
        };
        self.line = line;
        Ok(word)
    }

    fn index(&mut self, what: &str) -> Result<usize> {
        let word = self.word(what)?;
        word.parse().map_err(|_| self.wrong(&format!("{what} must be a whole number, is {word}")))
    }

    fn exactly(&mut self, what: &str, expected: usize) -> Result<()> {
        match self.index(what)? {
            found if found == expected => Ok(()),
            found => Err(self.wrong(&format!("{what} must be {expected}, is {found}"))),
        }
    }

    fn number(&mut self, what: &str) -> Result<f64> {
        let word = self.word(what)?;
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.wrong(&format!("{what} must be a finite number, is {word}")))
    }

    fn vector(&mut self, what: &str) -> Result<DVec3> {
        Ok(DVec3::new(self.number(what)?, self.number(what)?, self.number(what)?))
    }

    /// Column by column.
    fn block(&mut self) -> Result<DMat3> {
        let what = "a value of a block";
        Ok(DMat3::from_cols(self.vector(what)?, self.vector(what)?, self.vector(what)?))
    }

    /// Where each row of blocks begins; one more for the end.
    fn starts(&mut self, rows: usize, count: usize) -> Result<Vec<usize>> {
        let mut starts: Vec<usize> = Vec::new();
        for row in 0..=rows {
            let start = self.index("a row start")?;
            let least = starts.last().copied().unwrap_or(0);
            let fits = if row == 0 { start == 0 } else { (least..=count).contains(&start) };
            if !fits || (row == rows && start != count) {
                return Err(
                    self.wrong(&format!("row starts must go up from 0 to {count}, row {row} starts at {start}"))
                );
            }
            starts.push(start);
        }
        Ok(starts)
    }

    fn columns(&mut self, contacts: usize, count: usize) -> Result<Vec<usize>> {
        let mut columns = Vec::new();
        for _ in 0..count {
            let column = self.index("a column index")?;
            if column >= contacts {
                return Err(self.wrong(&format!("a block in column {column}, but there are {contacts} contacts")));
            }
            columns.push(column);
        }
        Ok(columns)
    }

    fn end(&mut self) -> Result<()> {
        match self.words.next() {
            None => Ok(()),
            Some((line, word)) => {
                Err(Error::invalid(format!("line {line}"), format!("nothing should follow μ: {word}")))
            }
        }
    }
}
