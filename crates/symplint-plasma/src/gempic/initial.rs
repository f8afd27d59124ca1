//! Initial states: the test cases of Kraus et al. 2017, section 6, and random ones.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use super::electromagnetic::Gempic;
use super::physical::PhysicalState;
use super::quiet::quiet_draws;
use crate::pic::wave_quantile;
use symplint_models::ModelError;
use symplint_models::random::Uniform;

/// How a plasma starts: electrons, with one wavelength in the box, k = 2π/L, and Gauss' law satisfied.
///
/// All but [`Random`](Self::Random) are quiet starts, shifted by random numbers of a seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialPlasma {
    /// The Weibel instability of an anisotropic plasma: σ1 = 0.02/√2, σ2 = √12 σ1, B = A cos kx. For k = 1.25 it grows
    /// at the rate 0.02784.
    Weibel,
    /// The streaming Weibel instability: a sixth of the particles in a beam v2 = 0.5, the others in one of −0.1, both of
    /// σ = 0.1/√2, B = A cos kx. For k = 0.2 it grows at the rate 0.03999.
    StreamingWeibel,
    /// Landau damping: σ1 = σ2 = 1, the density 1 + A cos kx. For k = 0.5 its frequency is 1.4157 − 0.1534 i.
    Landau,
    /// Positions uniform, velocities from −1 to 1, coefficients of the potentials and of e2 from −A to A.
    Random,
}

impl InitialPlasma {
    /// All of them, by their names in configurations.
    pub const ALL: [(&'static str, InitialPlasma); 4] = [
        ("weibel", InitialPlasma::Weibel),
        ("streaming-weibel", InitialPlasma::StreamingWeibel),
        ("landau", InitialPlasma::Landau),
        ("random", InitialPlasma::Random),
    ];

    /// The length of the box of the test case; of random states, 2π.
    pub fn length(self) -> f64 {
        match self {
            InitialPlasma::Weibel => TAU / 1.25,
            InitialPlasma::StreamingWeibel => TAU / 0.2,
            InitialPlasma::Landau => TAU / 0.5,
            InitialPlasma::Random => TAU,
        }
    }

    /// The amplitude A of the test case; of random states, 1/2.
    pub fn amplitude(self) -> f64 {
        match self {
            InitialPlasma::Weibel => -1e-4,
            InitialPlasma::StreamingWeibel => -1e-3,
            InitialPlasma::Landau | InitialPlasma::Random => 0.5,
        }
    }

    /// Positions and momenta of `gempic`, as the rows of a state.
    ///
    /// # Errors
    /// If the amplitude is not finite, or that of the density is not from −1 to 1.
    pub fn sample(
        self,
        gempic: &Gempic,
        amplitude: f64,
        seed: u64,
    ) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        ModelError::check_finite("the amplitude of the initial state", amplitude)?;
        if self == InitialPlasma::Landau && !(-1.0..=1.0).contains(&amplitude) {
            return Err(ModelError::OutOfRange {
                what: "the amplitude of the density wave",
                value: amplitude,
                remedy: "give a number from -1 to 1, for a density cannot be negative",
            });
        }
        let mut state = match self {
            InitialPlasma::Random => random(gempic, amplitude, seed),
            quiet => quiet.quiet(gempic, amplitude, seed),
        };
        state.e1 = gempic.electrostatic_field(&state.x);
        gempic.state(&state)
    }

    fn quiet(self, gempic: &Gempic, amplitude: f64, seed: u64) -> PhysicalState {
        let particles = gempic.weights().len();
        let mut state = at_rest(gempic);
        let deviations = match self {
            InitialPlasma::Weibel => [
                0.02 * FRAC_1_SQRT_2,
                0.02 * FRAC_1_SQRT_2 * libm::sqrt(12.0),
            ],
            InitialPlasma::StreamingWeibel => [0.1 * FRAC_1_SQRT_2; 2],
            InitialPlasma::Landau | InitialPlasma::Random => [1.0; 2],
        };
        // All particles of a place together carry no transverse current: there are both signs of v2, and of the two
        // beams one and five of six.
        let copies = match self {
            InitialPlasma::Landau | InitialPlasma::Random => 1,
            InitialPlasma::Weibel => 2,
            InitialPlasma::StreamingWeibel => 12,
        };
        for (a, draw) in quiet_draws(particles, copies, seed).enumerate() {
            let (place, beam) = match self {
                InitialPlasma::Landau => (wave_quantile(amplitude, 1.0, draw.place), 0.0),
                InitialPlasma::StreamingWeibel if draw.copy < 2 => (draw.place, 0.5),
                InitialPlasma::StreamingWeibel => (draw.place, -0.1),
                InitialPlasma::Weibel | InitialPlasma::Random => (draw.place, 0.0),
            };
            state.x[a] = gempic.length() * place;
            state.v1[a] = deviations[0] * draw.normals[0];
            state.v2[a] = beam + deviations[1] * draw.normals[1];
        }
        if self != InitialPlasma::Landau {
            state.a2 = gempic.sine_potential(amplitude);
        }
        state
    }
}

fn at_rest(gempic: &Gempic) -> PhysicalState {
    let (particles, cells) = (gempic.weights().len(), gempic.cells());
    let (of_particles, of_fields) = (vec![0.0; particles], vec![0.0; cells]);
    PhysicalState {
        x: of_particles.clone(),
        y: of_particles.clone(),
        v1: of_particles.clone(),
        v2: of_particles,
        a1: of_fields.clone(),
        a2: of_fields.clone(),
        e1: of_fields.clone(),
        e2: of_fields,
    }
}

fn random(gempic: &Gempic, amplitude: f64, seed: u64) -> PhysicalState {
    let mut uniform = Uniform::from_seed(seed);
    let mut state = at_rest(gempic);
    let mut draw = |values: &mut [f64], low: f64, high: f64| {
        for (value, u) in values.iter_mut().zip(&mut uniform) {
            *value = low + (high - low) * u;
        }
    };
    draw(&mut state.x, 0.0, gempic.length());
    for velocities in [&mut state.v1, &mut state.v2] {
        draw(velocities, -1.0, 1.0);
    }
    for field in [&mut state.a1, &mut state.a2, &mut state.e2] {
        draw(field, -amplitude, amplitude);
    }
    state
}

impl Gempic {
    /// Coefficients e1 of the field, of mean 0, of particles at rest at `x` and the background.
    ///
    /// # Panics
    /// If there is not one position for each particle.
    pub fn electrostatic_field(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.weights.len(), "a position for each particle");
        let cells = self.cells();
        let mut charges = vec![0.0; cells];
        self.charges_at(x, &mut charges);
        let background = charges.iter().sum::<f64>() / cells as f64;
        // (M1 e1)_j+1 − (M1 e1)_j is the charge of function j.
        let mut flux = 0.0;
        let mut field: Vec<f64> = (charges.iter())
            .map(|charge| {
                let here = flux;
                flux += self.charge * (charge - background);
                here
            })
            .collect();
        let mean = field.iter().sum::<f64>() / cells as f64;
        for flux in &mut field {
            *flux -= mean;
        }
        self.masses.solve(&mut field, &mut charges);
        field
    }

    /// Coefficients a2 of a field B with the Fourier mode `amplitude` × cos(2πx/L) and no other but its aliases.
    fn sine_potential(&self, amplitude: f64) -> Vec<f64> {
        let (cells, degree) = (self.cells(), self.degree());
        let k = TAU / self.length();
        // A spline of degree p is p + 1 times smoothed over a cell.
        let half_cell = PI / cells as f64;
        let smoothing = (libm::sin(half_cell) / half_cell).powi(degree as i32 + 1);
        let size = match cells {
            // One function is constant: the field vanishes.
            1 => 0.0,
            _ => amplitude / (k * smoothing),
        };
        (0..cells)
            .map(|j| {
                let centre = (j as f64 + 0.5 * (degree + 1) as f64) / cells as f64;
                size * libm::sin(TAU * centre)
            })
            .collect()
    }
}
