"""Where a camera with a lens sees points, as OpenCV's documentation of calib3d has it; pixels as COLMAP and Nerfstudio count
them, from the corner of the top left one."""
import numpy as np


def project(points, fx, fy, cx, cy, k1=0, k2=0, p1=0, p2=0, k3=0, k4=0, k5=0, k6=0):
    """points: N x 3 in the camera's frame, x right, y down, z forward, z > 0."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x * x + y * y
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([fx * u + cx, fy * v + cy], axis=1)


def within(pixels, depth, width, height, margin=1):
    """Those before the camera and within its picture."""
    return (
        (depth > 0.1)
        & (pixels[:, 0] >= margin)
        & (pixels[:, 1] >= margin)
        & (pixels[:, 0] < width - margin)
        & (pixels[:, 1] < height - margin)
    )


def rotation(qw, qx, qy, qz):
    """Of a unit quaternion, Hamilton's convention."""
    return np.array(
        [
            [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz), 2 * (qx * qz + qw * qy)],
            [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qw * qx)],
            [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx), 1 - 2 * (qx * qx + qy * qy)],
        ]
    )
