// Looks up each message of a log as lcm-spy does, and decodes it.
// SPDX-License-Identifier: BSD-3-Clause
import java.io.DataInput;
import java.io.EOFException;
import lcm.lcm.LCMDataInputStream;
import lcm.logging.Log;
import lcm.spy.LCMTypeDatabase;

public class KnownMessages {
  public static void main(String[] arguments) throws Exception {
    LCMTypeDatabase types = new LCMTypeDatabase();
    Log log = new Log(arguments[0], "r");
    int known = 0;
    try {
      while (true) {
        Log.Event event = log.readNext();
        Class<?> type = types.getClassByFingerprint(new LCMDataInputStream(event.data).readLong());
        if (type == null) throw new Exception("lcm-spy does not know the type on " + event.channel);
        type.getConstructor(DataInput.class).newInstance(new LCMDataInputStream(event.data));
        System.out.println(event.channel + " " + type.getName());
        ++known;
      }
    } catch (EOFException end) {
      System.out.println(known + " messages known");
    }
  }
}
