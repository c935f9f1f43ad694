//! Bodies slide and roll over seams as over one surface.
