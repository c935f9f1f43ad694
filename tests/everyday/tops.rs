//! Tops, coins and wheels keep their spin.
