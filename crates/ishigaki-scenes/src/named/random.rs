//! The random numbers of scenes.

/// SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators"): a counter and a hash.
///
/// Integers and multiplication by powers of two only, so that scenes are the same on every machine.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// Equal seeds give equal numbers.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A rotation, uniform over all (by rejection of points in the cube around the 4-ball).
    pub fn rotation(&mut self) -> ishigaki::Quat {
        loop {
            let [x, y, z, w] = [(); 4].map(|()| self.between(-1.0, 1.0));
            let square = x * x + y * y + z * z + w * w;
            if (0.01..=1.0).contains(&square) {
                let length = square.sqrt();
                return ishigaki::Quat::from_xyzw(x / length, y / length, z / length, w / length);
            }
        }
    }
}
