"""The lumped-thermal spindle: machine file, thermal network, effects, structure and sensors."""
