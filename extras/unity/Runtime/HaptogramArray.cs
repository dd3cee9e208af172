// SPDX-License-Identifier: Apache-2.0
// An array of transducers in a Unity scene: put this onto an object that lies where the array lies, y up from the transducers.
// Unity's frame is left-handed with y up, the array's right-handed with z up: x stays, y and z change places.
using UnityEngine;

namespace Haptogram
{
    public sealed class HaptogramArray : MonoBehaviour
    {
        [Tooltip("/dev/ttyUSB0, ftdi:…, or reference:tile-100-wide for a simulated board")]
        public string port = "reference:tile-100-wide";

        [Tooltip("The board, a shipped one or a configuration")]
        public string board = "tile-100-wide";

        [Tooltip("The array, a shipped one or a file")]
        public string array = "tile-10x10";

        [Tooltip("What the focus follows; nothing is silence")]
        public Transform target;

        [Range(0, 1)] public float strength = 1;

        [Tooltip("Modulation, such as sine:200; a focus at rest is not felt without one")]
        public string modulation = "sine:200";

        [Tooltip("Silence when no frame has moved the focus for so long, ms, and outputs off when the whole program has gone")]
        public uint watchdogMs = 500;

        private Board _board;

        /// <summary>Where a point of the scene is in the array's frame, metres.</summary>
        public Focus FocusAt(Vector3 world, float amplitude)
        {
            Vector3 here = transform.InverseTransformPoint(world);
            return new Focus(here.x, here.z, here.y, amplitude);
        }

        private void OnEnable()
        {
            try
            {
                _board = new Board(port);
                using (Image image = Image.OfFoci(new[] { new Focus(0, 0, 0.15) }, null, board, array, true)) _board.Upload(image);
                _board.SetFocus(0, 0, 0.15, 0);
                _board.PlayLive(0, string.IsNullOrEmpty(modulation) ? null : modulation, watchdogMs);
            }
            catch (HaptogramException error)
            {
                Debug.LogError(error.Message, this);
                OnDisable();
            }
        }

        private void Update()
        {
            if (_board == null) return;
            try
            {
                if (!_board.Wait(0)) OnDisable();  // it has ended by itself
                else if (target == null) _board.SetFocus(0, 0, 0.15, 0);
                else _board.SetFocus(FocusAt(target.position, strength));
            }
            catch (HaptogramException error)
            {
                Debug.LogWarning(error.Message, this);  // a focus out of reach, which is silence, or a board that is gone
                if (error.Code != Code.BadInput) OnDisable();
            }
        }

        /// <summary>Turns the outputs off. Unity calls it also when the scene or the program ends.</summary>
        private void OnDisable()
        {
            Board board = _board;
            _board = null;
            board?.Dispose();
        }
    }
}
