"""What people type. Each module is one installed command."""
