//! The two elements of a pair.

/// A function of both elements of a pair.
pub trait Both<T> {
    /// Calls a function with either element, as `map` does. Before it is optimized, `map` is some 200 lines of intermediate code for each
    /// closure, because it must be able to stop between any two elements; this is three calls.
    fn both<U>(self, function: impl FnMut(T) -> U) -> [U; 2];
}

impl<T> Both<T> for [T; 2] {
    #[inline(always)]
    fn both<U>(self, mut function: impl FnMut(T) -> U) -> [U; 2] {
        let [one, other] = self;
        [function(one), function(other)]
    }
}
