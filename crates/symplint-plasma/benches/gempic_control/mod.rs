//! A step of Kraus et al. as a textbook writes it: in physical variables, flow by flow, particle by particle.

use symplint_models::bspline::weights;

/// Equal particles on a periodic line; buffers made once.
pub struct PlainGempic {
    pub degree: usize,
    pub cells: usize,
    pub length: f64,
    pub charge: f64,
    pub mass: f64,
    pub weight: f64,
    /// First columns of M0⁻¹ and M1⁻¹, which are circulant.
    pub inverse0: Vec<f64>,
    pub inverse1: Vec<f64>,
    /// Row 0 of M1.
    pub m1: Vec<f64>,
    pub x: Vec<f64>,
    pub v1: Vec<f64>,
    pub v2: Vec<f64>,
    pub e1: Vec<f64>,
    pub e2: Vec<f64>,
    pub b: Vec<f64>,
    pub current: Vec<f64>,
    pub work: Vec<f64>,
}

impl PlainGempic {
    fn width(&self) -> f64 {
        self.length / self.cells as f64
    }

    /// The cell and the fraction of a position.
    fn place(&self, x: f64) -> (usize, f64) {
        let position = x.rem_euclid(self.length) / self.width();
        let cell = (position as usize).min(self.cells - 1);
        (cell, position - cell as f64)
    }

    /// Function j of those of `degree` on a cell.
    fn function(&self, degree: usize, cell: usize, j: usize) -> usize {
        (cell + self.cells - degree + j) % self.cells
    }

    fn evaluate(&self, degree: usize, coefficients: &[f64], x: f64) -> f64 {
        let (cell, fraction) = self.place(x);
        let weights = weights(degree, fraction);
        (0..=degree)
            .map(|j| weights[j] * coefficients[self.function(degree, cell, j)])
            .sum()
    }

    /// e += the inverse, times `factor`, times the current.
    fn solve(current: &[f64], inverse: &[f64], factor: f64, e: &mut [f64]) {
        let cells = e.len();
        for (i, e) in e.iter_mut().enumerate() {
            for (j, current) in current.iter().enumerate() {
                *e += factor * inverse[(i + cells - j) % cells] * current;
            }
        }
    }

    fn electric(&mut self, h: f64) {
        let ratio = h * self.charge / self.mass;
        for a in 0..self.x.len() {
            let x = self.x[a];
            self.v1[a] += ratio * self.evaluate(self.degree - 1, &self.e1, x) / self.width();
            self.v2[a] += ratio * self.evaluate(self.degree, &self.e2, x);
        }
        for j in 0..self.cells {
            self.b[j] -= h * (self.e2[j] - self.e2[(j + self.cells - 1) % self.cells]);
        }
    }

    fn magnetic(&mut self, h: f64) {
        let n = self.cells;
        for i in 0..n {
            self.work[i] = (0..n).map(|j| self.m1[(i + n - j) % n] * self.b[j]).sum();
        }
        for i in 0..n {
            self.current[i] = self.work[i] - self.work[(i + 1) % n];
        }
        Self::solve(&self.current, &self.inverse0, h, &mut self.e2);
    }

    /// Cell by cell along the path, by Gauss–Legendre quadrature with three points, exact to degree 5.
    fn along(&mut self, h: f64) {
        const NODES: [(f64, f64); 3] = [
            (0.112_701_665_379_258_31, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ];
        let (width, degree) = (self.width(), self.degree - 1);
        self.current.fill(0.0);
        for a in 0..self.x.len() {
            let (start, end) = (self.x[a] / width, (self.x[a] + h * self.v1[a]) / width);
            let (low, high) = (start.min(end), start.max(end));
            let sign = (end - start).signum();
            let mut field = 0.0;
            let mut from = low;
            while from < high {
                let cell = from.floor();
                let to = high.min(cell + 1.0);
                let index = (cell as i64).rem_euclid(self.cells as i64) as usize;
                for (node, share) in NODES {
                    let weights = weights(degree, from + node * (to - from) - cell);
                    for (j, weight) in weights.iter().take(degree + 1).enumerate() {
                        let function = self.function(degree, index, j);
                        let integral = sign * share * (to - from) * weight;
                        field += integral * self.b[function];
                        self.current[function] += self.weight * self.charge * integral;
                    }
                }
                from = to;
            }
            self.v2[a] -= self.charge / self.mass * field;
            self.x[a] += h * self.v1[a];
        }
        Self::solve(&self.current, &self.inverse1, -1.0, &mut self.e1);
    }

    fn across(&mut self, h: f64) {
        let ratio = h * self.charge / self.mass;
        self.current.fill(0.0);
        for a in 0..self.x.len() {
            let (x, v2) = (self.x[a], self.v2[a]);
            self.v1[a] += ratio * v2 * self.evaluate(self.degree - 1, &self.b, x) / self.width();
            let (cell, fraction) = self.place(x);
            let weights = weights(self.degree, fraction);
            for (j, weight) in weights.iter().take(self.degree + 1).enumerate() {
                let function = self.function(self.degree, cell, j);
                self.current[function] += h * self.weight * self.charge * v2 * weight;
            }
        }
        Self::solve(&self.current, &self.inverse0, -1.0, &mut self.e2);
    }

    /// A Strang step, H_E first.
    pub fn step(&mut self, h: f64) {
        self.electric(0.5 * h);
        self.magnetic(0.5 * h);
        self.along(0.5 * h);
        self.across(h);
        self.along(0.5 * h);
        self.magnetic(0.5 * h);
        self.electric(0.5 * h);
    }
}
