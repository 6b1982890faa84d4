"""An example of plug-ins for spindle-drift: an effect, an error model and an importer."""
