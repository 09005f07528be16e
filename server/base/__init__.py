"""What every room stands on: settings, errors, middleware, paths, what the application hands to its routes."""
