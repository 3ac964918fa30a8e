//! Runs a loop compiled for the widest registers that the machine has; the only file here that names the crate for it.

use pulp::{Arch, Simd, WithSimd};

/// Work that the compiler does on several numbers at once where it may.
pub(super) trait Wide {
    /// What it gives.
    type Output;

    /// Does it; inlined always, or it would be compiled for the narrowest registers.
    fn run(self) -> Self::Output;
}

/// Does it in the widest registers.
pub(super) fn widest<W: Wide>(work: W) -> W::Output {
    Arch::new().dispatch(Widest(work))
}

struct Widest<W>(W);

impl<W: Wide> WithSimd for Widest<W> {
    type Output = W::Output;

    // no registers are named: the compiler knows them
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run()
    }
}
