//! Bodies and colliders below other entities.
