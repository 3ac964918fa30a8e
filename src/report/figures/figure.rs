//! Holds a finished figure, and the file names of those that show all particles.

/// A finished figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// file name
    pub name: String,
    /// the picture
    pub svg: String,
}

/// File of the figure of e_inf and St_c against the film ratio.
pub const FILM: &str = "e_inf-st_c-film_ratio.svg";
/// File of the figure of the energy balance against the film ratio.
pub const ENERGY: &str = "energy-film_ratio.svg";
/// File of the figure of mean residuals against the film ratio.
pub const RESIDUALS: &str = "residuals-film_ratio.svg";
/// File of the posterior's figure of draws of each pair of parameters.
pub const PAIRS: &str = "posterior-pairs.svg";
