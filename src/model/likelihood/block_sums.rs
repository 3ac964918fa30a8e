//! Holds sums over the runs of a block.

/// Sums over the rebounds of a block: Σ n d², and with w = n d m′ Σ w, Σ w x, Σ w e_dry p, d being e − m(r).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BlockSums {
    pub squares: f64,
    pub kept: f64,
    pub viscous: f64,
    pub dry: f64,
    /// Σ w G with G = g exp(C′ f)
    pub shape: f64,
    /// Σ w dG/dδ̃0
    pub scale: f64,
    /// Σ w x f
    pub viscous_trend: f64,
    /// Σ w G f
    pub inertial_trend: f64,
    /// Σ w q, where tails are heavy: with q = (d/σ)² in units of Student's t, w = (ν + 1)/(ν + q) and the sums above weighted
    /// by w, but for the squares
    pub weighted: f64,
    /// Σ ln(1 + q/ν)
    pub ln_tails: f64,
}

impl BlockSums {
    /// Multiplies all but the squares and what tails have of their own.
    pub fn weigh_slopes(&mut self, weight: f64) {
        self.slopes().into_iter().for_each(|slope| *slope *= weight);
    }

    /// Adds so many times all but the squares and what tails have of their own.
    pub fn add_slopes(&mut self, mut more: BlockSums, times: f64) {
        for (slope, more) in self.slopes().into_iter().zip(more.slopes()) {
            *slope += times * *more;
        }
    }

    fn slopes(&mut self) -> [&mut f64; 7] {
        [
            &mut self.kept,
            &mut self.viscous,
            &mut self.dry,
            &mut self.shape,
            &mut self.scale,
            &mut self.viscous_trend,
            &mut self.inertial_trend,
        ]
    }
}
