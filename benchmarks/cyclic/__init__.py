"""Bladed disks: what sector meshes and mistuned disks take."""
