// SPDX-License-Identifier: Apache-2.0
// A sphere under a tracked hand: the palm feels it where it is nearest, while it is inside.
using Haptogram;
using UnityEngine;

public sealed class TouchedSphere : MonoBehaviour
{
    public HaptogramArray haptics;
    public Transform palm;
    public float radius = 0.04f;

    private void Update()
    {
        float inside = radius - Vector3.Distance(palm.position, transform.position);
        haptics.target = inside > 0 ? palm : null;
        haptics.strength = Mathf.Clamp01(0.4f + inside / radius);
    }
}
