//! The systems, one a file, named as the file.

pub mod advance_paths;
pub mod collect_emission;
pub mod collect_sensor;
pub mod connect_emission;
pub mod connect_to_emitters;
pub mod connect_to_sensor;
pub mod connect_to_vertices;
pub mod depolarize_light;
pub mod depolarize_sensor;
pub mod emit_light_paths;
pub mod fly_through_media;
pub mod gather_connections;
pub mod generate_sensor_paths;
pub mod merge_photons;
pub mod partition_paths;
pub mod play_roulette;
pub mod scatter_light;
pub mod scatter_medium;
pub mod scatter_surfaces;
pub mod store_light_vertices;
pub mod store_photons;
pub mod trace_connections;
pub mod weigh_arrival;
